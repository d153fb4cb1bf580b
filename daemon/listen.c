/* Sockets that clients connect to. */
#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "listen.h"

/* Bytes that may be under way to a client: with more, tiles would be stale when they are seen. */
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

static void name_lock(const struct pro_address *address, char *out_name, size_t size)
{
    snprintf(out_name, size, "%s.lock", address->path);
}

/* Lock the file beside the socket before the old socket is checked, and until the listener ends. Otherwise
 * one of two daemons that start at once might remove the new socket of the other. */
static bool lock(struct dmn_listener *listener, char out_error[PRO_ERROR_SIZE])
{
    const struct pro_address *address = &listener->address;
    char name[sizeof(address->path) + 8];
    struct stat own, there;
    int fd;

    name_lock(address, name, sizeof(name));
    for (;;) {
        fd = open(name, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
        if (fd < 0) return fail(address, out_error, "its .lock: %s", strerror(errno));
        if (fstat(fd, &own) || !S_ISREG(own.st_mode) || own.st_uid != geteuid()) {
            close(fd);
            return fail(address, out_error, "its .lock: expected a file of this user, or none");
        }
        /* Not every file system has locks. */
        if (flock(fd, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK) {
            close(fd);
            return fail(address, out_error, "in use by a running daemon");
        }
        if (!lstat(name, &there) && there.st_dev == own.st_dev && there.st_ino == own.st_ino) break;
        /* A daemon that ended meanwhile has removed this file: its lock keeps nobody out. */
        close(fd);
    }
    listener->lock = fd;
    return true;
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
    /* EAGAIN: a daemon listens, and is busy. */
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
    if (!lock(listener, out_error) || !make_way(address, &name, out_error)) return false;
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

    *listener = (struct dmn_listener){
        .address = *address, .fd = -1, .lock = -1, .token = address->is_unix ? NULL : token};
    good = address->is_unix ? listen_unix(listener, out_error) : listen_tcp(listener, out_error);
    if (!good) dmn_listener_finish(listener);
    return good;
}

void dmn_listener_finish(struct dmn_listener *listener)
{
    char name[sizeof(listener->address.path) + 8];
    struct stat status;

    if (listener->fd >= 0) close(listener->fd);
    listener->fd = -1;
    if (listener->inode && !lstat(listener->address.path, &status) && status.st_dev == listener->device &&
        status.st_ino == listener->inode)
        unlink(listener->address.path);
    listener->inode = 0;
    if (listener->lock < 0) return;
    name_lock(&listener->address, name, sizeof(name));
    unlink(name); /* nobody else has locked it */
    close(listener->lock);
    listener->lock = -1;
}

/* --- clients */

bool dmn_peer_is_own(const struct dmn_peer *peer)
{
    return peer->is_local && (peer->user == geteuid() || peer->user == 0);
}

/* False if the system does not tell the user. */
static bool meet_unix(int fd, struct dmn_peer *out_peer)
{
    struct ucred who;
    socklen_t length = sizeof(who);

    if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &length)) return false;
    *out_peer = (struct dmn_peer){.is_local = true, .user = who.uid};
    snprintf(out_peer->name, sizeof(out_peer->name), "process %d", (int)who.pid);
    return true;
}

static void meet_tcp(int fd, struct dmn_peer *out_peer)
{
    struct sockaddr_storage name = {0};
    socklen_t length = sizeof(name);
    char host[64], port[8];

    *out_peer = (struct dmn_peer){.name = "tcp"};
    if (!getpeername(fd, (struct sockaddr *)&name, &length) &&
        !getnameinfo((struct sockaddr *)&name, length, host, sizeof(host), port, sizeof(port),
                     NI_NUMERICHOST | NI_NUMERICSERV))
        snprintf(out_peer->name, sizeof(out_peer->name), "%s port %s", host, port);
    out_peer->key = dmn_gate_key(&name);
}

int dmn_listener_accept(struct dmn_listener *listener, struct dmn_peer *out_peer)
{
    int fd, bytes = SEND_BUFFER;

    for (;;) {
        fd = accept4(listener->fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (fd < 0 && (errno == EINTR || errno == ECONNABORTED)) continue;
        if (fd < 0 || !listener->address.is_unix || meet_unix(fd, out_peer)) break;
        close(fd);
    }
    if (fd < 0) {
        /* Out of descriptors: the listener stays readable, so pause a little. */
        if (errno == EMFILE || errno == ENFILE) poll(NULL, 0, 10);
        return -1;
    }
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof(bytes));
    if (listener->address.is_unix) return fd;
    pro_tcp_options(fd);
    meet_tcp(fd, out_peer);
    return fd;
}
