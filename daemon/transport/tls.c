/* Certificates and keys for TLS, by OpenSSL. */
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include "transport/tls.h"

enum { MOST_BYTES = 1 << 20 };

struct dmn_tls {
    X509 *certificate;
    STACK_OF(X509) * chain; /* of its issuers */
    EVP_PKEY *key;
    SSL_CTX *context; /* which shows that OpenSSL takes them */
};

static bool fail(char out_error[PRO_ERROR_SIZE], const char *path, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static bool fail(char out_error[PRO_ERROR_SIZE], const char *path, const char *format, ...)
{
    char why[256];
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(why, sizeof(why), format, arguments);
    va_end(arguments);
    snprintf(out_error, PRO_ERROR_SIZE, "--tls: %.200s: %s", path, why);
    ERR_clear_error();
    return false;
}

/* --- files --- */

static bool check_file(const char *path, const struct stat *status, bool is_key,
                       char out_error[PRO_ERROR_SIZE])
{
    const mode_t others = status->st_uid == 0 ? S_IWGRP | S_IXGRP | S_IRWXO : S_IRWXG | S_IRWXO;

    if (!S_ISREG(status->st_mode)) return fail(out_error, path, "it is no regular file");
    if (status->st_size > MOST_BYTES)
        return fail(out_error, path, "it has %lld bytes, where a PEM file of at most %d was expected",
                    (long long)status->st_size, MOST_BYTES);
    if (is_key && status->st_mode & others)
        return fail(out_error, path, "others can read or change this key, of mode %03o: chmod %03o",
                    (unsigned)status->st_mode & 0777, (unsigned)(status->st_mode & 0777 & ~others));
    return true;
}

/* The bytes of a file, for the caller to free. NULL with a line in out_error. */
static BIO *read_file(const char *path, bool is_key, char out_error[PRO_ERROR_SIZE])
{
    /* O_NONBLOCK: a pipe is refused, not waited for. */
    const int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    BIO *bytes = NULL;
    char part[4096];
    struct stat status;
    ssize_t count = 0;
    size_t total = 0;
    bool good;

    if (fd < 0 || fstat(fd, &status))
        good = fail(out_error, path, "%s", strerror(errno));
    else
        good = check_file(path, &status, is_key, out_error);
    if (good && !(bytes = BIO_new(BIO_s_secmem()))) good = fail(out_error, path, "out of memory");
    while (good && total <= MOST_BYTES && (count = read(fd, part, sizeof(part))) > 0) {
        if (BIO_write(bytes, part, (int)count) != count) good = fail(out_error, path, "out of memory");
        total += (size_t)count;
    }
    if (good && count < 0) good = fail(out_error, path, "%s", strerror(errno));
    if (fd >= 0) close(fd);
    OPENSSL_cleanse(part, sizeof(part));
    if (good) return bytes;
    BIO_free(bytes);
    return NULL;
}

/* Was OpenSSL's last error that the file holds no (further) PEM block of the kind that was asked for? */
static bool is_end(void)
{
    const unsigned long error = ERR_peek_last_error();

    return ERR_GET_LIB(error) == ERR_LIB_PEM && ERR_GET_REASON(error) == PEM_R_NO_START_LINE;
}

/* What OpenSSL says is wrong. */
static const char *reason(void)
{
    const char *text = ERR_reason_error_string(ERR_peek_last_error());

    return text ? text : "for an unknown reason";
}

/* OpenSSL asks for a passphrase: there is none. */
static int no_passphrase(char *buffer, int size, int writing, void *was_asked)
{
    (void)buffer, (void)size, (void)writing;
    *(bool *)was_asked = true;
    return -1;
}

static bool read_certificates(struct dmn_tls *tls, const char *path, char out_error[PRO_ERROR_SIZE])
{
    BIO *bytes = read_file(path, false, out_error);
    X509 *issuer;
    bool good = true, was_asked;

    if (!bytes) return false;
    tls->certificate = PEM_read_bio_X509_AUX(bytes, NULL, no_passphrase, &was_asked);
    if (!tls->certificate && is_end())
        good = fail(out_error, path, "there is no certificate in it: expected -----BEGIN CERTIFICATE-----");
    else if (!tls->certificate)
        good = fail(out_error, path, "its certificate cannot be read: %s", reason());
    while (good && (issuer = PEM_read_bio_X509(bytes, NULL, no_passphrase, &was_asked))) {
        if (sk_X509_push(tls->chain, issuer)) continue;
        X509_free(issuer);
        good = fail(out_error, path, "out of memory");
    }
    if (good && !is_end())
        good = fail(out_error, path, "its certificate number %d cannot be read: %s",
                    sk_X509_num(tls->chain) + 2, reason());
    ERR_clear_error();
    BIO_free(bytes);
    return good;
}

static bool read_key(struct dmn_tls *tls, const char *path, char out_error[PRO_ERROR_SIZE])
{
    static const char mark[] = "PRIVATE KEY-----";
    BIO *bytes = read_file(path, true, out_error);
    bool was_asked = false, is_there;
    char *text;
    long count;

    if (!bytes) return false;
    count = BIO_get_mem_data(bytes, &text);
    is_there = count > 0 && memmem(text, (size_t)count, mark, strlen(mark));
    tls->key = is_there ? PEM_read_bio_PrivateKey(bytes, NULL, no_passphrase, &was_asked) : NULL;
    BIO_free(bytes);
    if (tls->key) return true;
    if (!is_there)
        return fail(out_error, path, "there is no key in it: expected -----BEGIN PRIVATE KEY-----");
    if (was_asked) return fail(out_error, path, "its key has a passphrase, where one without was expected");
    return fail(out_error, path, "its key cannot be read: %s", reason());
}

/* --- life --- */

struct dmn_tls *dmn_tls_load(const char *certificate, const char *key, char out_error[PRO_ERROR_SIZE])
{
    struct dmn_tls *tls = calloc(1, sizeof(*tls));
    bool good = tls && (tls->chain = sk_X509_new_null()) && (tls->context = SSL_CTX_new(TLS_server_method()));

    if (!good) fail(out_error, certificate, "out of memory");
    good = good && read_certificates(tls, certificate, out_error) && read_key(tls, key, out_error);
    if (good && X509_check_private_key(tls->certificate, tls->key) != 1)
        good = fail(out_error, key, "it is not the key of the certificate in %.200s", certificate);
    if (good && SSL_CTX_use_cert_and_key(tls->context, tls->certificate, tls->key, tls->chain, 1) != 1)
        good = fail(out_error, certificate, "it cannot be used: %s", reason());
    if (good) return tls;
    dmn_tls_destroy(tls);
    return NULL;
}

void dmn_tls_destroy(struct dmn_tls *tls)
{
    if (!tls) return;
    SSL_CTX_free(tls->context);
    EVP_PKEY_free(tls->key);
    sk_X509_pop_free(tls->chain, X509_free);
    X509_free(tls->certificate);
    free(tls);
}

/* --- libwebsockets --- */

void dmn_tls_prepare(const struct dmn_tls *tls, struct lws_context_creation_info *info)
{
    info->options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
    /* libwebsockets would else make another one, with all certificates of the system, for connections that
     * the daemon would begin; there are none. */
    info->provided_client_ssl_ctx = tls->context;
}

void dmn_tls_ask(const struct dmn_tls *tls, struct lws_context_creation_info *info)
{
    info->options |= LWS_SERVER_OPTION_CREATE_VHOST_SSL_CTX;
    info->alpn = "http/1.1"; /* libwebsockets would choose HTTP/2, which has many streams in one connection */
    info->user = (void *)tls;
}

bool dmn_tls_use(void *user, void *in)
{
    const struct dmn_tls *tls = lws_vhost_user(in);

    return SSL_CTX_use_cert_and_key(user, tls->certificate, tls->key, tls->chain, 1) == 1;
}
