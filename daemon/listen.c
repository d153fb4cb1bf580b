/* Sockets that clients connect to. */
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "listen.h"

/* Bytes under way to a client before it counts as slow: more would only be stale by the time it is seen. */
enum { SEND_BUFFER = 256 << 10, BACKLOG = 16 };

static bool fail(const struct pro_address *address, char out_error[PRO_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static bool fail(const struct pro_address *address, char out_error[PRO_ERROR_SIZE], const char *format, ...)
{
    char name[PRO_ERROR_SIZE - 160], why[128];
    va_list args;

    pro_address_print(address, name, sizeof(name));
    va_start(args, format);
    vsnprintf(why, sizeof(why), format, args);
    va_end(args);
    snprintf(out_error, PRO_ERROR_SIZE, "%s: %s", name, why);
    return false;
}

/* Make way for a Unix socket: nothing there, or what a dead daemon left. */
static bool make_way(const struct pro_address *address, const struct sockaddr_un *name,
                     char out_error[PRO_ERROR_SIZE])
{
    struct stat status;
    int fd, result, cause;

    if (lstat(address->path, &status)) {
        if (errno == ENOENT) return true;
        return fail(address, out_error, "%s", strerror(errno));
    }
    if (!S_ISSOCK(status.st_mode))
        return fail(address, out_error, "there is a file of that name, not a socket");
    fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return fail(address, out_error, "%s", strerror(errno));
    result = connect(fd, (const struct sockaddr *)name, sizeof(*name));
    cause = errno;
    close(fd);
    /* EAGAIN: someone listens, and is busy. */
    if (!result || cause == EAGAIN) return fail(address, out_error, "in use by a running daemon");
    if (cause != ECONNREFUSED) return fail(address, out_error, "%s", strerror(cause));
    if (unlink(address->path))
        return fail(address, out_error, "cannot remove the old socket: %s", strerror(errno));
    return true;
}

static bool listen_unix(struct dmn_listener *listener, char out_error[PRO_ERROR_SIZE])
{
    const struct pro_address *address = &listener->address;
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    struct stat status;

    memcpy(name.sun_path, address->path, sizeof(name.sun_path));
    if (!make_way(address, &name, out_error)) return false;
    listener->fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (listener->fd < 0) return fail(address, out_error, "%s", strerror(errno));
    /* Linux gives the new file the mode of the unbound socket, so at no moment can others open it. */
    if (fchmod(listener->fd, 0600) || bind(listener->fd, (struct sockaddr *)&name, sizeof(name)) ||
        stat(address->path, &status))
        return fail(address, out_error, "%s", strerror(errno));
    listener->device = status.st_dev;
    listener->inode = status.st_ino;
    if (listen(listener->fd, BACKLOG)) return fail(address, out_error, "%s", strerror(errno));
    return true;
}

static bool listen_tcp(struct dmn_listener *listener, char out_error[PRO_ERROR_SIZE])
{
    const struct pro_address *address = &listener->address;
    struct addrinfo want = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE | AI_NUMERICSERV}, *found;
    char port[8];
    int result, cause = 0, one = 1;

    if (!listener->token && !pro_address_is_local(address))
        return fail(address, out_error,
                    "other machines can reach it: set FOVEAD_TOKEN in the environment first");
    snprintf(port, sizeof(port), "%u", address->port);
    result = getaddrinfo(address->host, port, &want, &found);
    if (result) return fail(address, out_error, "%s", gai_strerror(result));
    for (struct addrinfo *a = found; a && listener->fd < 0; a = a->ai_next) {
        listener->fd = socket(a->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
        if (listener->fd < 0) {
            cause = errno;
            continue;
        }
        setsockopt(listener->fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof(one));
        if (bind(listener->fd, a->ai_addr, a->ai_addrlen) || listen(listener->fd, BACKLOG)) {
            cause = errno;
            close(listener->fd);
            listener->fd = -1;
        }
    }
    freeaddrinfo(found);
    if (listener->fd < 0)
        return fail(address, out_error, "%s", cause == EADDRINUSE ? "the port is in use" : strerror(cause));
    return true;
}

bool dmn_listener_init(struct dmn_listener *listener, const struct pro_address *address, const char *token,
                       char out_error[PRO_ERROR_SIZE])
{
    bool good;

    *listener = (struct dmn_listener){*address, -1, pro_address_is_local(address) ? NULL : token, 0, 0};
    good = address->is_unix ? listen_unix(listener, out_error) : listen_tcp(listener, out_error);
    if (!good) dmn_listener_finish(listener);
    return good;
}

void dmn_listener_finish(struct dmn_listener *listener)
{
    struct stat status;

    if (listener->fd >= 0) close(listener->fd);
    listener->fd = -1;
    if (listener->inode && !lstat(listener->address.path, &status) && status.st_dev == listener->device &&
        status.st_ino == listener->inode)
        unlink(listener->address.path);
    listener->inode = 0;
}

static void name_peer(const struct dmn_listener *listener, int fd, char *out_peer, size_t size)
{
    if (listener->address.is_unix) {
        struct ucred who = {0};
        socklen_t length = sizeof(who);

        getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &length);
        snprintf(out_peer, size, "process %d", (int)who.pid);
    } else {
        struct sockaddr_storage name;
        socklen_t length = sizeof(name);
        char host[64], port[8];

        if (getpeername(fd, (struct sockaddr *)&name, &length) ||
            getnameinfo((struct sockaddr *)&name, length, host, sizeof(host), port, sizeof(port),
                        NI_NUMERICHOST | NI_NUMERICSERV))
            snprintf(out_peer, size, "tcp");
        else
            snprintf(out_peer, size, "%s port %s", host, port);
    }
}

int dmn_listener_accept(struct dmn_listener *listener, char *out_peer, size_t size)
{
    int fd, one = 1, bytes = SEND_BUFFER;

    do fd = accept4(listener->fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    while (fd < 0 && (errno == EINTR || errno == ECONNABORTED));
    if (fd < 0) {
        /* Out of descriptors: the listener stays readable, so take a breath instead of spinning. */
        if (errno == EMFILE || errno == ENFILE) poll(NULL, 0, 10);
        return -1;
    }
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof(bytes));
    if (!listener->address.is_unix) setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof(one));
    name_peer(listener, fd, out_peer, size);
    return fd;
}
