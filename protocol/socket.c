/* socket.c: waiting and connecting, until a deadline. */
#include "internal.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

static const uint64_t retry_ns = 20 * 1000 * 1000;

uint64_t pro_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

uint64_t pro_deadline_ns(int timeout_ms)
{
    return timeout_ms < 0 ? PRO_NEVER : pro_now_ns() + (uint64_t)timeout_ms * 1000000;
}

short pro_wait(int fd, short events, uint64_t deadline_ns)
{
    struct pollfd poll = {.fd = fd, .events = events};
    for (;;) {
        uint64_t now = pro_now_ns();
        uint64_t left = deadline_ns > now ? deadline_ns - now : 0;
        struct timespec timeout = {(time_t)(left / 1000000000), (long)(left % 1000000000)};
        int count = ppoll(&poll, 1, deadline_ns == PRO_NEVER ? NULL : &timeout, NULL);
        if (count > 0) return poll.revents;
        if (count == 0 || errno != EINTR) return 0;
    }
}

void pro_tcp_options(int fd)
{
    /* Acknowledgements and gaze are small and must not wait for one another. */
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &(int){1}, sizeof(int));
    /* After half a minute of silence the peer is asked three times, ten seconds apart; what has been sent may
     * wait as long to be taken. */
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &(int){1}, sizeof(int));
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &(int){30}, sizeof(int));
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &(int){10}, sizeof(int));
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &(int){3}, sizeof(int));
    setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &(unsigned){60000}, sizeof(unsigned));
}

/* Whoever listens on a Unix socket gets what is sent and decides what is shown: this must be this user, or
 * root, who may do so anyway. The credentials are those at listen(), which a later owner of the path cannot
 * change. */
static bool is_trusted(int fd, const char *name, char out_error[PRO_ERROR_SIZE])
{
    struct ucred peer;
    socklen_t size = sizeof peer;
    if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
        return pro_fail(out_error, "cannot tell who listens at %s: %s", name, strerror(errno));
    return peer.uid == geteuid() || peer.uid == 0 ||
           pro_fail(out_error, "user %u listens at %s, expected user %u: nothing was sent",
                    (unsigned)peer.uid, name, (unsigned)geteuid());
}

/* One attempt. Returns the socket, or -1 with errno. */
static int attempt(int family, const struct sockaddr *to, socklen_t length, uint64_t deadline_ns)
{
    int fd = socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    int error = connect(fd, to, length) == 0 ? 0 : errno;
    /* A connect() that a signal interrupts goes on, as one in progress. */
    if (error == EINPROGRESS || error == EINTR) {
        socklen_t size = sizeof error;
        if (!pro_wait(fd, POLLOUT, deadline_ns))
            error = ETIMEDOUT;
        else if (getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0)
            error = errno;
    }
    if (error == 0) {
        if (family != AF_UNIX) pro_tcp_options(fd);
        return fd;
    }
    close(fd);
    errno = error;
    return -1;
}

static int attempt_all(const struct pro_address *address, const struct addrinfo *found, uint64_t deadline_ns)
{
    if (address->is_unix) {
        struct sockaddr_un to = {.sun_family = AF_UNIX};
        memcpy(to.sun_path, address->path, sizeof to.sun_path);
        return attempt(AF_UNIX, (struct sockaddr *)&to, sizeof to, deadline_ns);
    }
    uint64_t candidates = 0;
    for (const struct addrinfo *one = found; one; one = one->ai_next) candidates++;
    for (const struct addrinfo *one = found; one; one = one->ai_next, candidates--) {
        /* An address that never answers leaves time for the others. */
        uint64_t now = pro_now_ns(), until = deadline_ns;
        if (deadline_ns != PRO_NEVER && deadline_ns > now) until = now + (deadline_ns - now) / candidates;
        int fd = attempt(one->ai_family, one->ai_addr, one->ai_addrlen, until);
        if (fd >= 0) return fd;
    }
    return -1;
}

int pro_dial(const struct pro_address *address, uint64_t deadline_ns, bool wait_for_daemon,
             char out_error[PRO_ERROR_SIZE])
{
    char name[sizeof address->host + 16];
    pro_address_print(address, name, sizeof name);
    struct addrinfo *found = NULL;
    if (address->is_http) {
        pro_fail(out_error, "%s: browsers connect there; expected unix:PATH or tcp:HOST:PORT", name);
        return -1;
    }
    if (!address->is_unix) {
        char port[8];
        snprintf(port, sizeof port, "%u", address->port);
        struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICSERV};
        int status = getaddrinfo(address->host, port, &hints, &found);
        if (status != 0) {
            pro_fail(out_error, "%s: %s", name, gai_strerror(status));
            return -1;
        }
    }
    int fd;
    while ((fd = attempt_all(address, found, deadline_ns)) < 0) {
        int error = errno;
        bool absent = error == ENOENT || error == ECONNREFUSED;
        bool again = (absent && wait_for_daemon) || error == EAGAIN; /* EAGAIN: its queue is full */
        uint64_t now = pro_now_ns();
        if (!again || now >= deadline_ns) {
            pro_fail(out_error, "%s %s: %s", absent ? "nothing listens at" : "cannot connect to", name,
                     strerror(error));
            break;
        }
        uint64_t pause = deadline_ns - now < retry_ns ? deadline_ns - now : retry_ns;
        pro_wait(-1, 0, now + pause);
    }
    if (found) freeaddrinfo(found);
    if (fd >= 0 && address->is_unix && !is_trusted(fd, name, out_error)) {
        close(fd);
        return -1;
    }
    return fd;
}
