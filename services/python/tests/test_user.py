"""Topics of a user's own: names, forms, and the schema hash that other languages compute, too."""

import unittest

from zeronav import contract as c
from zeronav.errors import UsageError
from zeronav.user import Form, topic_of


class Forms(unittest.TestCase):
    def test_a_form_names_numbers_or_bytes(self):
        form = Form("distance_m: f64,n:u16 , x_m :f32")
        self.assertEqual(form.numbers, ("distance_m", "n", "x_m"))
        self.assertEqual(form.record.size, 14)
        for text in ("json", "distance_m: f65", "a: u8,", "A: u8", "my::Type v2"):
            self.assertIsNone(Form(text).record, text)
        for text in ("", " a", "a ", "a\n", "ä", "x" * (c.FORM_BYTES_MAX + 1)):
            with self.assertRaises(UsageError, msg=repr(text)):
                Form(text)

    def test_names_are_words(self):
        form, long = Form("json"), "a" * c.USER_NAME_BYTES_MAX
        for name in ("nearest", "a", "a_1", long):
            self.assertTrue(topic_of(name, form).name.endswith(f"/{name}"))
        for name in ("", "1a", "A", "a/b", "a b", "ä", "_a", "a\n", f"{long}a"):
            with self.assertRaises(UsageError, msg=repr(name)):
                topic_of(name, form)

    def test_the_schema_hash_is_that_of_the_crate(self):
        topic = topic_of("nearest", Form("distance_m: f64"))
        self.assertEqual(topic.schema, 0x096A_19E2_C7B9_1C46)


if __name__ == "__main__":
    unittest.main()
