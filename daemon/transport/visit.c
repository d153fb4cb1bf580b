/* The headers of a browser's request, and the page's files. */
#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "transport/visit.h"

/* The name in a Host header, without its port and brackets. False if there is no such name. */
static bool name_of(const char *host, char *out_name, size_t size)
{
    const char *begin = host, *end = host + strcspn(host, ":"), *port = end;

    if (*host == '[') {
        begin = host + 1;
        end = strchr(begin, ']');
        if (!end) return false;
        port = end + 1;
    }
    if (*port && (*port != ':' || port[1 + strspn(port + 1, "0123456789")])) return false;
    if (end == begin || (size_t)(end - begin) >= size) return false;
    memcpy(out_name, begin, (size_t)(end - begin));
    out_name[end - begin] = '\0';
    return true;
}

/* Is it a name of this machine? */
static bool is_own_name(const char *name)
{
    char own[256] = "", local[sizeof(own) + 8];
    int first;

    if (gethostname(own, sizeof(own) - 1)) return false;
    first = (int)strcspn(own, ".");
    snprintf(local, sizeof(local), "%.*s.local", first, own);
    return !strcasecmp(name, own) || !strcasecmp(name, local) ||
           ((int)strlen(name) == first && !strncasecmp(name, own, (size_t)first));
}

bool dmn_visit_host_is_good(const char *host, const struct dmn_listener *listener)
{
    unsigned char address[sizeof(struct in6_addr)];
    char name[256];

    if (!name_of(host, name, sizeof(name))) return false;
    return !strcasecmp(name, "localhost") || !strcasecmp(name, listener->address.host) ||
           inet_pton(AF_INET, name, address) == 1 || inet_pton(AF_INET6, name, address) == 1 ||
           (listener->token && !pro_address_is_local(&listener->address) && is_own_name(name));
}

bool dmn_visit_origin_is_good(const char *origin, const char *host, const struct dmn_listener *listener)
{
    const char *scheme = listener->is_tls ? "https://" : "http://";
    const size_t length = strlen(scheme);

    return !*origin || (!strncmp(origin, scheme, length) && !strcasecmp(origin + length, host));
}

const struct dmn_page_file *dmn_visit_file(const char *path)
{
    for (size_t i = 0; i < dmn_page_count; i++)
        if (!strcmp(dmn_page[i].path, path)) return &dmn_page[i];
    return NULL;
}
