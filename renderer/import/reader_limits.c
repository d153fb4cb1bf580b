/* The limits of programs that read files, for those programs and for the one that starts them. */
#include "import/reader.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

struct rnd_reader_limits rnd_reader_limits(const struct rnd_scene_options *options, const char *path)
{
    enum { MIB = 4096, SECONDS = 20, BYTES_A_SECOND = 2 << 20 };
    const uint64_t half = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE) >> 21;
    struct stat status;
    struct rnd_reader_limits limits = {options->reader_mib, options->reader_seconds};
    if (limits.mib == 0) limits.mib = half < MIB ? (uint32_t)half : MIB;
    if (limits.seconds == 0)
        limits.seconds = SECONDS + (uint32_t)(stat(path, &status) == 0 && S_ISREG(status.st_mode)
                                                  ? status.st_size / BYTES_A_SECOND
                                                  : 0);
    return limits;
}

double rnd_reader_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void limit(int what, rlim_t value)
{
    const struct rlimit both = {value, value};
    setrlimit(what, &both);
}

static void end(void)
{
    _exit(RND_READER_MEMORY);
}

/* C++'s std::set_new_handler(): what is called when new finds no memory. */
void (*rnd_set_new_handler(void (*)(void)))(void) __asm__("_ZSt15set_new_handlerPFvvE");

void rnd_reader_limit_time(uint32_t seconds)
{
    const struct itimerval wall = {.it_value.tv_sec = (time_t)seconds * RND_READER_PATIENCE};
    struct rlimit processor = {RLIM_INFINITY, RLIM_INFINITY};
    struct timespec used;
    if (seconds > 0 && clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used) == 0)
        processor.rlim_cur = (rlim_t)used.tv_sec + seconds;
    setrlimit(RLIMIT_CPU, &processor);
    setitimer(ITIMER_REAL, &wall, NULL);
}

void rnd_reader_begin(pid_t parent, uint32_t mib)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(RND_READER_REFUSES);
    signal(SIGSEGV, SIG_DFL); /* a crash ends the reader by its signal, even if a sanitizer would report it */
    signal(SIGBUS, SIG_DFL);
    signal(SIGFPE, SIG_DFL);
    signal(SIGILL, SIG_DFL);
    limit(RLIMIT_CORE, 0);
    rnd_set_new_handler(end);
    if (mib == 0) return;
    limit(RLIMIT_FSIZE, (rlim_t)mib << 20);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) /* sanitizers take terabytes of
                                                                       addresses */
    limit(RLIMIT_DATA, (rlim_t)mib << 20);
#endif
}
