/* The transports. */
#include "transport/table.h"
#include "transport/raw.h"

static const struct dmn_transport *const TRANSPORTS[] = {
    &dmn_raw,
};

const struct dmn_transport *dmn_transport_at(size_t index)
{
    return index < sizeof(TRANSPORTS) / sizeof(*TRANSPORTS) ? TRANSPORTS[index] : NULL;
}
