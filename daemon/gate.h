/* gate: decides when a client's token is checked, so that nobody can try many.
 *
 * After a wrong token, tokens from the same address are checked one per second. Right tokens wait too: if
 * they were let in at once, a guesser would know that all others are wrong. Every address has a gate of its
 * own, so that a stranger who guesses does not keep out those who know the token. But addresses cost nothing
 * (a network of IPv6, all of 127.0.0.0/8): so a network counts as one address, and the number of places is
 * fixed. A new address takes over the place that is free soonest, with its wait (as in Space-Saving, Metwally
 * et al. 2005). So at most DMN_GATE_PLACES guesses are checked per second.
 *
 * The caller passes the time, so that tests need not wait. For one thread. */
#ifndef FOVEAD_DAEMON_GATE_H
#define FOVEAD_DAEMON_GATE_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

enum { DMN_GATE_PLACES = 16, DMN_GATE_QUEUE = 8 /* turns that may be given in advance */ };

/* All zero: open to everybody. */
struct dmn_gate {
    struct {
        uint64_t key, next_ns; /* when the next token from there is checked */
    } place[DMN_GATE_PLACES];
};

/* What counts as one address: a machine of IPv4, a network of 64 bits of IPv6, this machine. */
uint64_t dmn_gate_key(const struct sockaddr_storage *address);

/* When to check a token from there: now_ns, or a later turn, which is kept for it; 0: too many wait already.
 */
uint64_t dmn_gate_turn(struct dmn_gate *gate, uint64_t key, uint64_t now_ns);
/* A token that was checked without a wait was wrong. */
void dmn_gate_wrong(struct dmn_gate *gate, uint64_t key, uint64_t now_ns);

/* A token that had waited for its turn was right: give its second back to those who come later. */
void dmn_gate_right(struct dmn_gate *gate, uint64_t key);

/* Are the tokens equal? Takes as long however much of given is right. */
bool dmn_gate_knows(const char *token, const char *given);

#endif
