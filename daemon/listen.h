/* listen: the sockets that clients connect to, and which of them may be opened. */
#ifndef FOVEAD_DAEMON_LISTEN_H
#define FOVEAD_DAEMON_LISTEN_H

#include <sys/types.h>

#include "gate.h"
#include "protocol.h"

struct dmn_listener {
    struct pro_address address;
    int fd;   /* non-blocking */
    int lock; /* of a Unix socket: the file beside it, which is locked while it is listened on; else -1 */
    const char *token; /* that clients must know; NULL: they need none */
    bool is_tls;       /* clients must speak TLS; dmn_listener_init() sets it to false */
    dev_t device;      /* of a Unix socket, so that no other one is removed */
    ino_t inode;
};

/* Open a socket and listen. A Unix socket is this user's alone, and needs no token; one that a dead daemon
 * left behind is replaced, one that answers and anything that is not a socket is refused. Of several that
 * begin at once one gets it. On TCP clients must know the token if there is one, and an address that other
 * machines reach is refused without. False with a line in out_error that names the address. The caller ends
 * it with dmn_listener_finish(). */
bool dmn_listener_init(struct dmn_listener *listener, const struct pro_address *address, const char *token,
                       char out_error[PRO_ERROR_SIZE]);
/* Close it; a Unix socket is removed from its folder. */
void dmn_listener_finish(struct dmn_listener *listener);

/* A client at the other end of a socket. */
struct dmn_peer {
    char name[96]; /* for people */
    uint64_t key;  /* for the gate */
    bool is_local; /* a process on this machine, on a Unix socket; then: */
    uid_t user;    /* the user that it runs as */
};

/* Is it a process of this user or of root, on a Unix socket? */
bool dmn_peer_is_own(const struct dmn_peer *peer);

/* Accept the next client. Returns a non-blocking socket, or -1 if no more are waiting. */
int dmn_listener_accept(struct dmn_listener *listener, struct dmn_peer *out_peer);

#endif
