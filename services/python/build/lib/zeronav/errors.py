"""Why a process could not start, and the exit code that says so."""

EXIT_STOPPED = 0
EXIT_CRASH = 1


class StartError(Exception):
    """Something that a restart may cure."""

    exit_code = EXIT_CRASH


class UsageError(StartError):
    """Bad flags or a bad configuration. Not restarted."""

    exit_code = 2


class ContractError(StartError):
    """A topic has another layout than this package knows, or does not exist. Not restarted."""

    exit_code = 3

    def __init__(self, topic, problem):
        super().__init__(f"contract: topic {topic}: {problem}")


class MemoryShortage(StartError):
    """Too little shared memory, which a later restart may find."""

    exit_code = 4

    def __init__(self, needed, free):
        super().__init__(
            f"shared memory: {needed} bytes more are needed in /dev/shm and {free} are free; "
            "enlarge it (docker: --shm-size) or remove what fills it"
        )
