/* gate: when a client's token is looked at, so that nobody can try many.
 *
 * A wrong token closes the gate for a second to the address that it came from. Clients that come from there
 * meanwhile wait for turns, one a second. Right tokens wait too: if they were let in at once, a guesser need
 * not wait for the other answers. Every address has a gate of its own, for behind one gate a stranger who
 * guesses would keep out those who know the token. But addresses cost nothing (a network of IPv6, all of
 * 127.0.0.0/8). So a network counts as one address, and the number of places is fixed: a new address takes
 * over the place that is free soonest, with the wait of that place (as in Space-Saving, Metwally et al.
 * 2005). So at most DMN_GATE_PLACES guesses are looked at per second.
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

/* A token that had waited for its turn was right: the second that it took is given back to those who come
 * later. */
void dmn_gate_right(struct dmn_gate *gate, uint64_t key);

/* Are they the same? In a time that does not tell how much of it was right. */
bool dmn_gate_knows(const char *token, const char *given);

#endif
