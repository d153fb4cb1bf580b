/* tls: the certificate and the key with which listeners for browsers speak TLS. OpenSSL reads them here, so
 * that whatever is wrong with them is told in one line, before anything else is done. */
#ifndef FOVEAD_DAEMON_TRANSPORT_TLS_H
#define FOVEAD_DAEMON_TRANSPORT_TLS_H

#include <libwebsockets.h>

#include "protocol.h"

struct dmn_tls;

/* Read PEM files: the certificate, which may be followed by those of its issuers, and its key, without a
 * passphrase. Each is a regular file of at most 1 MiB. A key is refused that others can read, write or
 * execute; only a key of root may be readable by its group (as in PostgreSQL). NULL with a line in out_error
 * that names the file. */
struct dmn_tls *dmn_tls_load(const char *certificate, const char *key, char out_error[PRO_ERROR_SIZE]);
void dmn_tls_destroy(struct dmn_tls *tls); /* accepts NULL */

/* Prepare a libwebsockets context for TLS. Each of its virtual hosts uses TLS only if it asks for it. tls
 * must outlive the context. */
void dmn_tls_prepare(const struct dmn_tls *tls, struct lws_context_creation_info *info);
/* Make a virtual host use TLS. Its first protocol must call dmn_tls_use() on
 * LWS_CALLBACK_OPENSSL_LOAD_EXTRA_SERVER_VERIFY_CERTS. */
void dmn_tls_ask(const struct dmn_tls *tls, struct lws_context_creation_info *info);
/* Give the certificates and the key to libwebsockets: user and in as its callback has them. False if they
 * cannot be used. */
bool dmn_tls_use(void *user, void *in);

#endif
