/* Loaded before the C library: the time of day is an hour ahead while the file that ZERONAV_SET_CLOCK names exists. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

int clock_gettime(clockid_t which, struct timespec *now)
{
    static int (*original)(clockid_t, struct timespec *);
    if (original == NULL)
        original = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    int failed = original(which, now);
    if (failed == 0 && which == CLOCK_REALTIME) {
        const char *set = getenv("ZERONAV_SET_CLOCK");
        if (set != NULL && access(set, F_OK) == 0)
            now->tv_sec += 3600;
    }
    return failed;
}
