/* When a client's token is checked. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <string.h>

#include "gate.h"

static const uint64_t PAUSE_NS = 1000000000;

uint64_t dmn_gate_key(const struct sockaddr_storage *address)
{
    const struct in6_addr *v6 = &((const struct sockaddr_in6 *)address)->sin6_addr;
    struct in_addr v4 = {htonl(INADDR_LOOPBACK)};
    uint64_t network;

    if (address->ss_family == AF_INET6 && !IN6_IS_ADDR_LOOPBACK(v6) && !IN6_IS_ADDR_V4MAPPED(v6)) {
        memcpy(&network, v6, sizeof(network));
        return network;
    }
    if (address->ss_family == AF_INET) v4 = ((const struct sockaddr_in *)address)->sin_addr;
    if (address->ss_family == AF_INET6 && IN6_IS_ADDR_V4MAPPED(v6)) memcpy(&v4, &v6->s6_addr[12], sizeof(v4));
    return ntohl(v4.s_addr) >> 24 == IN_LOOPBACKNET ? INADDR_LOOPBACK : ntohl(v4.s_addr);
}

/* The place of that address, or the place that it takes over. */
static uint64_t *next_of(struct dmn_gate *gate, uint64_t key)
{
    int soonest = 0;

    for (int i = 0; i < DMN_GATE_PLACES; i++) {
        if (gate->place[i].key == key) return &gate->place[i].next_ns;
        if (gate->place[i].next_ns < gate->place[soonest].next_ns) soonest = i;
    }
    gate->place[soonest].key = key;
    return &gate->place[soonest].next_ns;
}

uint64_t dmn_gate_turn(struct dmn_gate *gate, uint64_t key, uint64_t now_ns)
{
    uint64_t *next_ns = next_of(gate, key), turn_ns = *next_ns;

    if (turn_ns <= now_ns) return now_ns;
    if (turn_ns - now_ns > DMN_GATE_QUEUE * PAUSE_NS) return 0;
    *next_ns += PAUSE_NS;
    return turn_ns;
}

void dmn_gate_wrong(struct dmn_gate *gate, uint64_t key, uint64_t now_ns)
{
    *next_of(gate, key) = now_ns + PAUSE_NS;
}

void dmn_gate_right(struct dmn_gate *gate, uint64_t key)
{
    for (int i = 0; i < DMN_GATE_PLACES; i++)
        if (gate->place[i].key == key && gate->place[i].next_ns > PAUSE_NS)
            gate->place[i].next_ns -= PAUSE_NS;
}

bool dmn_gate_knows(const char *token, const char *given)
{
    size_t length = strlen(token), other = strlen(given);
    unsigned char differ = length != other;

    for (size_t i = 0; i < length; i++) differ |= (unsigned char)(token[i] ^ (i < other ? given[i] : 0));
    return !differ;
}
