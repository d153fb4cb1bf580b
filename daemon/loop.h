/* loop: sockets, timers and sessions on one thread, by libwebsockets. */
#ifndef FOVEAD_DAEMON_LOOP_H
#define FOVEAD_DAEMON_LOOP_H

#include "handles.h"
#include "jobs.h"
#include "listen.h"
#include "picture.h"

struct dmn_loop;
struct dmn_tls; /* transport/tls.h */

struct dmn_loop_options {
    const struct dmn_handles *handles;
    struct dmn_picture *picture;
    int signal_fd; /* an eventfd: readable when the loop should end; owned by the caller */
    struct dmn_listener *listener;
    int listeners;
    const struct dmn_tls *tls; /* for the listeners that speak it; NULL: none does */
    /* Four times a second. */
    void (*tick)(void *context);
    /* A job that no client asked for is done. */
    void (*job_done)(void *context, const struct dmn_job *job);
    void *context;
};

/* The caller keeps the listeners and the TLS. NULL with a line in out_error on failure. */
struct dmn_loop *dmn_loop_create(const struct dmn_loop_options *options, char out_error[PRO_ERROR_SIZE]);
void dmn_loop_destroy(struct dmn_loop *loop); /* drops all clients; accepts NULL */

/* Tell the loop that there may be news for clients. Any thread may call this. */
void dmn_loop_wake(void *loop);
/* Serve until the painter is done or signal_fd is readable. */
void dmn_loop_run(struct dmn_loop *loop);
/* Once the painter has stopped: update what is known of the picture, and have the viewer show all of it. */
void dmn_loop_complete(struct dmn_loop *loop);

#endif
