/* Packets about pictures; in both programs. */
#include "import/image_packet.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>

union one_fd {
    struct cmsghdr head;
    char room[CMSG_SPACE(sizeof(int))];
};

bool rnd_image_send(int socket, enum rnd_image_packet kind, const void *bytes, size_t count, int fd)
{
    const uint32_t number = kind;
    struct iovec parts[2] = {{(void *)(uintptr_t)&number, sizeof number}, {(void *)(uintptr_t)bytes, count}};
    union one_fd control = {.room = {0}};
    struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
    ssize_t sent;
    if (fd >= 0) {
        message.msg_control = &control;
        message.msg_controllen = sizeof control.room;
        control.head = (struct cmsghdr){
            .cmsg_len = CMSG_LEN(sizeof fd), .cmsg_level = SOL_SOCKET, .cmsg_type = SCM_RIGHTS};
        memcpy(CMSG_DATA(&control.head), &fd, sizeof fd);
    }
    while ((sent = sendmsg(socket, &message, MSG_NOSIGNAL)) < 0 && errno == EINTR) continue;
    return sent >= 0;
}

ssize_t rnd_image_receive(int socket, enum rnd_image_packet *out_kind, void *bytes, size_t count, int *out_fd)
{
    uint32_t number = 0;
    struct iovec parts[2] = {{&number, sizeof number}, {bytes, count}};
    union one_fd control = {.room = {0}};
    struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
    ssize_t got;
    if (out_fd) {
        *out_fd = -1;
        message.msg_control = &control;
        message.msg_controllen = sizeof control.room;
    }
    while ((got = recvmsg(socket, &message, MSG_CMSG_CLOEXEC)) < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got < (ssize_t)sizeof number) return -2;
    const struct cmsghdr *head = out_fd ? CMSG_FIRSTHDR(&message) : NULL;
    if (head && head->cmsg_level == SOL_SOCKET && head->cmsg_type == SCM_RIGHTS)
        memcpy(out_fd, CMSG_DATA(head), sizeof *out_fd);
    *out_kind = (enum rnd_image_packet)number;
    return got - (ssize_t)sizeof number;
}
