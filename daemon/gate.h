/* gate: when a client's token is looked at, so that nobody can try many.
 *
 * A wrong token closes the gate for a second to all that come from the same address; who comes meanwhile
 * waits for a turn, one a second. Whether a token is right is not said before its turn either: whoever
 * guesses would just not wait for the answers. Not to one gate for all: a stranger who guesses would keep
 * those out who know the token. Not to every address by itself: they cost nothing (a network of IPv6, all of
 * 127.0.0.0/8), so a network counts as one, and there is a fixed number of places, of which a new address
 * takes over the one that is free soonest, with what it has to wait (as in Metwally et al. 2005,
 * Space-Saving). All guesses together are thus DMN_GATE_PLACES a second at most.
 *
 * Time is the caller's, so that all of this is tested without waiting. One thread. */
#ifndef FOVEAD_DAEMON_GATE_H
#define FOVEAD_DAEMON_GATE_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

enum { DMN_GATE_PLACES = 16, DMN_GATE_QUEUE = 8 /* turns that are given beforehand */ };

/* All zero is open to all. */
struct dmn_gate {
    struct {
        uint64_t key, next_ns; /* when the next token from there is looked at */
    } place[DMN_GATE_PLACES];
};

/* What counts as one address: a machine of IPv4, a network of 64 bits of IPv6, this machine. */
uint64_t dmn_gate_key(const struct sockaddr_storage *address);

/* When a token from there is looked at: now_ns, or a later turn that is kept for it; 0: too many wait
 * already. */
uint64_t dmn_gate_turn(struct dmn_gate *gate, uint64_t key, uint64_t now_ns);
/* One that was looked at without a wait was wrong. */
void dmn_gate_wrong(struct dmn_gate *gate, uint64_t key, uint64_t now_ns);

/* One that had waited for its turn was right: it takes none of those behind it any time. */
void dmn_gate_right(struct dmn_gate *gate, uint64_t key);

/* Are they the same? In a time that does not tell how much of it was right. */
bool dmn_gate_knows(const char *token, const char *given);

#endif
