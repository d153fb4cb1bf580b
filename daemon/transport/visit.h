/* visit: what a browser's request needs before a session begins: a check of its headers, and the page's
 * files. */
#ifndef FOVEAD_DAEMON_TRANSPORT_VISIT_H
#define FOVEAD_DAEMON_TRANSPORT_VISIT_H

#include "transport/transport.h"

/* A file of the page, held in the program (page.c, made from protocol/web by page.cmake). */
struct dmn_page_file {
    const char *path, *type; /* as "/" and "text/html" */
    const unsigned char *bytes;
    size_t count;
};
extern const struct dmn_page_file dmn_page[];
extern const size_t dmn_page_count;

/* Does the Host header of a request name this listener? Another site can make its own name resolve to this
 * machine (DNS rebinding), and its pages then send that name. So these are accepted:
 * - the name that the listener was given, and localhost;
 * - any numeric address, because nobody can make an address resolve elsewhere;
 * - where other machines can connect: the name of this machine, as gethostname(2) has it, its part before the
 *   first dot, and that part with ".local" behind it (multicast DNS). Who can make these resolve to another
 *   machine is in this network, and has no token, which clients need there. */
bool dmn_visit_host_is_good(const char *host, const struct dmn_listener *listener);
/* Does the Origin header say that the page was served here? It is then "http://", or "https://" where TLS is
 * spoken, and the Host header. An empty origin is accepted: browsers always send one with a WebSocket, and
 * other programs need none. */
bool dmn_visit_origin_is_good(const char *origin, const char *host, const struct dmn_listener *listener);

/* The file at a path, or NULL. */
const struct dmn_page_file *dmn_visit_file(const char *path);

#endif
