/* address.c: addresses that daemons listen on, from text and to text. */
#include "internal.h"

#include <arpa/inet.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

_Static_assert(sizeof((struct pro_address){0}.path) == sizeof((struct sockaddr_un){0}.sun_path),
               "a path fits a sockaddr_un");

static bool parse_path(const char *path, struct pro_address *out_address, char out_error[PRO_ERROR_SIZE])
{
    size_t length = strlen(path), most = sizeof out_address->path - 1;
    if (length == 0) return pro_fail(out_error, "unix: has no path after it");
    if (length > most)
        return pro_fail(out_error, "%.200s...: %zu bytes, where a socket's path may have %zu", path, length,
                        most);
    out_address->is_unix = true;
    memcpy(out_address->path, path, length + 1);
    return true;
}

static bool parse_port(const char *text, uint16_t *out_port)
{
    size_t digits = strspn(text, "0123456789");
    if (digits == 0 || digits > 5 || text[digits] != '\0') return false;
    long port = strtol(text, NULL, 10);
    *out_port = (uint16_t)port;
    return port >= 1 && port <= 65535;
}

/* text is HOST:PORT, behind "tcp:" or "http:". */
static bool parse_host(const char *scheme, const char *text, struct pro_address *out_address,
                       char out_error[PRO_ERROR_SIZE])
{
    const char *host = text, *colon = strrchr(text, ':'), *end = colon;
    if (*text == '[') {
        host = text + 1;
        end = strchr(text, ']');
        if (!end || end[1] != ':')
            return pro_fail(out_error, "%s:%.200s: expected %s:[IPv6]:PORT", scheme, text, scheme);
        colon = end + 1;
    } else if (!colon) {
        return pro_fail(out_error, "%s:%.200s: no port; expected %s:HOST:PORT", scheme, text, scheme);
    } else if (strchr(text, ':') != colon) {
        return pro_fail(out_error, "%s:%.200s: an IPv6 address goes in brackets: %s:[::1]:PORT", scheme, text,
                        scheme);
    }
    size_t length = (size_t)(end - host);
    if (length == 0)
        return pro_fail(out_error, "%s:%.200s: no host; expected %s:HOST:PORT", scheme, text, scheme);
    if (length >= sizeof out_address->host)
        return pro_fail(out_error, "%s:%.200s...: too long a host", scheme, text);
    if (!parse_port(colon + 1, &out_address->port))
        return pro_fail(out_error, "%s:%.200s: the port is a number from 1 to 65535", scheme, text);
    memcpy(out_address->host, host, length);
    out_address->host[length] = '\0';
    return true;
}

/* Can nobody else put a socket into the folder, or take one out of it? */
static bool is_own_folder(const char *folder, char out_error[PRO_ERROR_SIZE])
{
    struct stat status;
    if (lstat(folder, &status) != 0)
        return pro_fail(out_error, "%.300s: no place for a socket: %s", folder, strerror(errno));
    if (S_ISDIR(status.st_mode) && status.st_uid == geteuid() && !(status.st_mode & (S_IWGRP | S_IWOTH)))
        return true;
    return pro_fail(
        out_error,
        "%.250s: no place for a socket: expected a folder of user %u that nobody else can write to; another "
        "place can be named, as unix:PATH",
        folder, (unsigned)geteuid());
}

/* The default address: in $XDG_RUNTIME_DIR, unless that is relative (XDG Base Directory Specification), else
 * in a folder of our own in /tmp. */
static bool parse_default(struct pro_address *out_address, char out_error[PRO_ERROR_SIZE])
{
    const char *runtime = getenv("XDG_RUNTIME_DIR");
    char folder[4096], path[4096 + 16];
    bool has_runtime = runtime && *runtime == '/';
    int length = has_runtime ? snprintf(folder, sizeof folder, "%s", runtime)
                             : snprintf(folder, sizeof folder, "/tmp/fovead-%u", (unsigned)geteuid());
    if (length >= (int)sizeof folder)
        return pro_fail(out_error, "XDG_RUNTIME_DIR is too long a path for a socket");
    /* lstat() would follow a symbolic link with a slash after it. */
    while (length > 1 && folder[length - 1] == '/') folder[--length] = '\0';
    snprintf(path, sizeof path, "%s/fovead.sock", folder);
    if (!parse_path(path, out_address, out_error)) return false;
    if (!has_runtime && mkdir(folder, 0700) != 0 && errno != EEXIST)
        return pro_fail(out_error, "%s: cannot be made: %s", folder, strerror(errno));
    return is_own_folder(folder, out_error);
}

bool pro_address_parse(const char *text, struct pro_address *out_address, char out_error[PRO_ERROR_SIZE])
{
    memset(out_address, 0, sizeof *out_address);
    if (!text) return parse_default(out_address, out_error);
    if (strncmp(text, "unix:", 5) == 0) return parse_path(text + 5, out_address, out_error);
    if (strncmp(text, "tcp:", 4) == 0) return parse_host("tcp", text + 4, out_address, out_error);
    if (strncmp(text, "http:", 5) == 0) {
        out_address->is_http = true;
        return parse_host("http", text + 5, out_address, out_error);
    }
    if (strchr(text, '/')) return parse_path(text, out_address, out_error);
    return pro_fail(
        out_error,
        "'%.200s' is no address: expected unix:PATH, tcp:HOST:PORT, http:HOST:PORT or a path with a '/'",
        text);
}

bool pro_address_is_local(const struct pro_address *address)
{
    struct in_addr v4;
    struct in6_addr v6;
    if (address->is_unix || strcasecmp(address->host, "localhost") == 0) return true;
    if (inet_pton(AF_INET, address->host, &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
    return inet_pton(AF_INET6, address->host, &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

void pro_address_print(const struct pro_address *address, char *out_text, size_t size)
{
    const char *scheme = address->is_http ? "http" : "tcp";
    if (address->is_unix)
        snprintf(out_text, size, "unix:%s", address->path);
    else if (strchr(address->host, ':'))
        snprintf(out_text, size, "%s:[%s]:%u", scheme, address->host, address->port);
    else
        snprintf(out_text, size, "%s:%s:%u", scheme, address->host, address->port);
}
