/* All transports. */
#include "transport/table.h"
#include "transport/raw.h"
#include "transport/web.h"

const struct dmn_transport *const dmn_transports[DMN_TRANSPORTS] = {
    &dmn_web,
    &dmn_raw,
};

int dmn_transport_of(const struct dmn_listener *listener)
{
    int i = 0;

    while (i < DMN_TRANSPORTS - 1 && dmn_transports[i]->is_http != listener->address.is_http) i++;
    return i;
}
