"""The configuration of a service. Annotations are text here, which must not matter."""

from __future__ import annotations

import dataclasses
import tempfile
import unittest

from zeronav import parameters
from zeronav.errors import UsageError


@dataclasses.dataclass(frozen=True)
class Config:
    gain: float = parameters.param(1.5, "A gain.", "1/s", 0.0, 9.0)
    free: float = parameters.param(0.0, "A number without a range.")
    name: str = parameters.param('a "b"', "A name.")
    on: bool = parameters.param(True, "A switch.")

    def __post_init__(self):
        if self.gain > 8.0 and self.on:
            raise ValueError("gain: above 8 the switch must be off")


def read(text):
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(text)
        file.flush()
        return parameters.read(Config, file.name)


class Parameters(unittest.TestCase):
    def test_they_are_written_as_they_are_read(self):
        self.assertEqual(read(parameters.as_toml(Config(gain=2.0))), Config(gain=2.0))
        self.assertEqual(read("gain = 2").gain, 2.0)

    def test_wrong_values_are_errors_of_usage(self):
        for text, why in [
            ("gain = 10.0", "gain: must be 0.0 to 9.0"),
            ('gain = "much"', "gain: must be a number"),
            ("on = 1", "on: must be a boolean"),
            ("free = nan", "free: must be a finite number"),
            ("free = 1" + "0" * 400, "free: must be a finite number"),
            ("gain = 8.5", "above 8 the switch must be off"),
        ]:
            with self.assertRaisesRegex(UsageError, why, msg=text):
                read(text)

    def test_types_are_listed(self):
        listed = parameters.as_json(Config)
        for kind in ("number", "string", "boolean"):
            self.assertIn(f'"type": "{kind}"', listed)


if __name__ == "__main__":
    unittest.main()
