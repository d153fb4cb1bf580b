/* visit: what a connection by HTTP needs before it has a session: a check of its headers, and the page's files. */
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
 * machine (DNS rebinding), and its pages then send that name. So a name must be the listener's own, or
 * localhost. Any numeric address is accepted, because nobody can make an address resolve elsewhere. */
bool dmn_visit_host_is_good(const char *host, const struct dmn_listener *listener);
/* Does the Origin header say that the page was served here, which is "http://" and the Host header? An empty
 * origin is accepted: browsers always send one, and other programs need none. */
bool dmn_visit_origin_is_good(const char *origin, const char *host);

/* The file at a path, or NULL. */
const struct dmn_page_file *dmn_visit_file(const char *path);

#endif
