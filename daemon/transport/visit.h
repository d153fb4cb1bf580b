/* visit: what a browser may ask for before it has a session: who it says it is, and the page's files. */
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

/* Does the request's Host header name this listener? A page of another site whose name was made to lead here
 * (DNS rebinding) has that name in it, so a name must be the listener's own, or localhost; addresses lead
 * nowhere else. */
bool dmn_visit_host_is_good(const char *host, const struct dmn_listener *listener);
/* Is the Origin header that of a page served here: its scheme and Host? Programs that are no browser send
 * none, and may come in. */
bool dmn_visit_origin_is_good(const char *origin, const char *host, bool is_secure);

/* The file at a path, or NULL. */
const struct dmn_page_file *dmn_visit_file(const char *path);

#endif
