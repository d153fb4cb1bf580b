/* viewer: shows the picture in tev or HDRView, by tev's protocol. It connects as soon as a viewer listens,
 * and again whenever the connection has ended; it opens the picture there, sends tiles as they get better,
 * and draws where the eye looks. A tile is read only when the socket has room, so that a viewer that stops
 * reading costs no more than the socket's buffer and one unfinished packet. For the loop's thread alone. */
#ifndef FOVEAD_DAEMON_VIEWER_H
#define FOVEAD_DAEMON_VIEWER_H

#include <libwebsockets.h>

#include "handles.h"
#include "picture.h"
#include "protocol.h"

struct dmn_viewer;

/* Begin to connect to address, which is TCP. The context, handles and the picture must outlive the viewer.
 * NULL if memory is short. */
struct dmn_viewer *dmn_viewer_create(struct lws_context *context, const struct pro_address *address,
                                     const struct dmn_handles *handles, const struct dmn_picture *picture);
/* Before the context is destroyed, which closes the connection. Accepts NULL. */
void dmn_viewer_destroy(struct dmn_viewer *viewer);

/* Is there a connection, so that the picture should be kept up to date? Accepts NULL. */
bool dmn_viewer_is_there(const struct dmn_viewer *viewer);

/* Once the picture changes no more: send all that the viewer lacks of it, as long as the viewer takes it,
 * for 20 seconds at most. Accepts NULL. */
void dmn_viewer_complete(struct dmn_viewer *viewer);

#endif
