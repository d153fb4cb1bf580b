// OpenImageIO behind image_io.h. Nothing is thrown across the boundary, and nothing else is done here.
#include "import/image_io.h"
#include "import/open_file.h"
#include "math/srgb.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace
{

bool fail(char *out_error, size_t error_size, std::string text)
{
    for (char &c : text)
        if (c == '\n' || c == '\r') c = ' ';
    while (!text.empty() && text.back() == ' ') text.pop_back();
    snprintf(out_error, error_size, "%s", text.empty() ? "unknown image error" : text.c_str());
    return false;
}

// The exponent by which the file's colours become linear light: 1 if they are, 0 if they are sRGB.
float gamma_of(const OIIO::ImageSpec &spec, rnd_pixels_use use)
{
    if (use == RND_PIXELS_DATA || spec.format.is_floating_point()) return 1.0f;
    if (use == RND_PIXELS_SRGB) return 0.0f;
    const std::string space = spec.get_string_attribute("oiio:ColorSpace");
    if (OIIO::Strutil::istarts_with(space, "lin")) return 1.0f;
    const float gamma = spec.get_float_attribute("oiio:Gamma", 2.2f);
    // What says 2.2 was made for sRGB and rounded.
    return gamma > 0.0f && fabsf(gamma - 2.2f) > 0.05f ? gamma : 0.0f;
}

// All channels but alpha to linear light.
void decode(float *values, size_t count, int channels, int alpha, float gamma)
{
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < channels; c++) {
            float &value = values[i * channels + c];
            if (c != alpha) value = gamma == 0.0f ? rnd_srgb_to_linear(value) : powf(value, gamma);
        }
}

// Rows that are read at a time: a few MiB of them, and whole tiles if the file has these.
int strip_of(const OIIO::ImageSpec &spec, size_t row)
{
    const int unit = spec.tile_height > 0 ? spec.tile_height : 64;
    const size_t rows = ((size_t)8 << 20) / row / unit * unit;
    return (int)std::min((size_t)spec.height, std::max(rows, (size_t)unit));
}

bool read(OIIO::ImageInput &in, const rnd_pixels_file &file, rnd_pixels_sink &sink, char *out_error,
          size_t error_size)
{
    const OIIO::ImageSpec &spec = in.spec();
    const int first_channel = file.channel ? spec.channelindex(file.channel) : 0;
    if (first_channel < 0)
        return fail(out_error, error_size, std::string("has no channel \"") + file.channel + "\"");
    if (spec.depth > 1) return fail(out_error, error_size, "a volume, not a picture");
    if (spec.width <= 0 || spec.height <= 0 || (int64_t)spec.width * spec.height > RND_MAX_PIXELS)
        return fail(out_error, error_size, "image size out of range");
    rnd_picture picture = {};
    picture.width = spec.width;
    picture.height = spec.height;
    picture.channels = file.channel ? 1 : std::min(spec.nchannels, (int)RND_MAX_CHANNELS);
    for (int c = 0; c < picture.channels; c++)
        snprintf(picture.channel_names[c], sizeof picture.channel_names[c], "%s",
                 std::string(spec.channel_name(first_channel + c)).c_str());

    const float gamma = gamma_of(spec, file.use);
    const bool as_bytes = file.use == RND_PIXELS_DATA || gamma == 0.0f;
    picture.bytes = file.want_bytes && as_bytes && spec.format == OIIO::TypeDesc::UINT8;
    picture.display = gamma != 1.0f;
    const size_t row = (size_t)picture.width * picture.channels * (picture.bytes ? 1 : sizeof(float));
    const int strip = strip_of(spec, row), n = picture.channels, end_channel = first_channel + n;
    const OIIO::TypeDesc type = picture.bytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT;
    std::unique_ptr<char, decltype(&free)> data((char *)malloc(strip * row), free);
    if (!data || !sink.begin(&sink, &picture)) return fail(out_error, error_size, "not enough memory");
    for (int y = 0; y < spec.height; y += strip) {
        const int rows = std::min(strip, spec.height - y), first = spec.y + y;
        const bool ok = spec.tile_width > 0
                            ? in.read_tiles(0, 0, spec.x, spec.x + spec.width, first, first + rows, spec.z,
                                            spec.z + 1, first_channel, end_channel, type, data.get())
                            : in.read_scanlines(0, 0, first, first + rows, spec.z, first_channel, end_channel,
                                                type, data.get());
        if (!ok) return fail(out_error, error_size, in.geterror());
        if (!picture.bytes && gamma != 1.0f)
            decode((float *)data.get(), (size_t)rows * picture.width, n, spec.alpha_channel - first_channel,
                   gamma);
        if (!sink.rows(&sink, y, rows, data.get())) return fail(out_error, error_size, "not enough memory");
    }
    return true;
}

// A sink that keeps all of it.
struct Keeper {
    rnd_pixels_sink sink; // first
    rnd_pixels *pixels;
    size_t row;
};

bool keep_begin(rnd_pixels_sink *sink, const rnd_picture *picture)
{
    Keeper &keeper = *(Keeper *)sink;
    rnd_pixels &out = *keeper.pixels;
    out.width = picture->width;
    out.height = picture->height;
    out.channels = picture->channels;
    out.display = picture->display;
    memcpy(out.channel_names, picture->channel_names, sizeof out.channel_names);
    keeper.row = (size_t)out.width * out.channels * (picture->bytes ? 1 : sizeof(float));
    void *data = malloc(keeper.row * out.height);
    (picture->bytes ? (void *&)out.bytes : (void *&)out.floats) = data;
    return data;
}

bool keep_rows(rnd_pixels_sink *sink, int first, int count, const void *pixels)
{
    Keeper &keeper = *(Keeper *)sink;
    rnd_pixels &out = *keeper.pixels;
    char *data = out.bytes ? (char *)out.bytes : (char *)out.floats;
    memcpy(data + first * keeper.row, pixels, count * keeper.row);
    return true;
}

OIIO::TypeDesc type_of(rnd_channel_type type)
{
    switch (type) {
    case RND_HALF:
        return OIIO::TypeDesc::HALF;
    case RND_BYTE:
        return OIIO::TypeDesc::UINT8;
    case RND_FLOAT:
        break;
    }
    return OIIO::TypeDesc::FLOAT;
}

// A file for OpenImageIO's encoders. It takes every byte, also when the disk is full: of encoders that meet a
// failed write, one ends the program (JPEG) and others go on and report success (EXR, PNG; 2.4.7).
class Sink : public OIIO::Filesystem::IOProxy
{
  public:
    explicit Sink(FILE *to) : IOProxy("", Write), file(to) {}
    const char *proxytype() const override { return "sink"; }
    // Put bytes between those of an encoder that never seeks: before its byte at that place.
    void insert(const std::string &bytes, int64_t place)
    {
        inserted = bytes;
        insert_at = place;
    }
    size_t write(const void *bytes, size_t count) override
    {
        const char *from = (const char *)bytes;
        const int64_t before = insert_at - m_pos;
        if (before >= 0 && before < (int64_t)count) {
            put(from, (size_t)before);
            put(inserted.data(), inserted.size());
            put(from + before, count - (size_t)before);
        } else {
            put(from, count);
        }
        m_pos += count;
        end = std::max(end, m_pos);
        return count;
    }
    bool seek(int64_t offset) override
    {
        m_pos = offset;
        return note(fseeko(file, offset, SEEK_SET) == 0);
    }
    size_t size() const override { return end; }
    // What has gone wrong first, as of errno; 0: all is with the system.
    int finish()
    {
        note(fflush(file) == 0 && !ferror(file));
        return why;
    }

  private:
    bool note(bool good)
    {
        if (!good && why == 0) why = errno != 0 ? errno : EIO;
        return good;
    }
    void put(const char *bytes, size_t count) { note(fwrite(bytes, 1, count, file) == count); }

    FILE *file;
    std::string inserted;
    int64_t insert_at = -1; // nowhere
    int64_t end = 0;
    int why = 0;
};

OIIO::ImageSpec spec_of(const rnd_layout &layout)
{
    const rnd_channel *channel = layout.channel, *last = channel + layout.channels;
    OIIO::ImageSpec spec(layout.width, layout.height, layout.channels, type_of(channel->type));
    spec.channelnames.clear();
    for (const rnd_channel *c = channel; c != last; c++) {
        spec.channelnames.push_back(c->name);
        spec.channelformats.push_back(type_of(c->type));
    }
    if (std::all_of(channel, last, [&](const rnd_channel &c) { return c.type == channel->type; }))
        spec.channelformats.clear();
    // OpenEXR files would get the time of day, and the same picture would be another file.
    if (strcmp(layout.format, "exr") == 0) spec.attribute("DateTime", "1970:01:01 00:00:00");
    spec.attribute("Software", "fovead " FOVEAD_VERSION);
    spec.attribute("compression", "zip");
    if (layout.equirectangular) {
        spec.attribute("textureformat", "LatLong Environment"); // OpenEXR: envmap = latlong
        // Photo Sphere XMP Metadata (Google), which OpenImageIO writes as XMP to JPEG alone.
        spec.attribute("GPano:UsePanoramaViewer", "True");
        spec.attribute("GPano:ProjectionType", "equirectangular");
        spec.attribute("GPano:PoseHeadingDegrees", 0.0f); // of the middle of the picture: forward is north
        spec.attribute("GPano:FullPanoWidthPixels", layout.width);
        spec.attribute("GPano:FullPanoHeightPixels", layout.height);
        spec.attribute("GPano:CroppedAreaImageWidthPixels", layout.width);
        spec.attribute("GPano:CroppedAreaImageHeightPixels", layout.height);
        spec.attribute("GPano:CroppedAreaLeftPixels", 0);
        spec.attribute("GPano:CroppedAreaTopPixels", 0);
    }
    return spec;
}

// The attributes of Photo Sphere XMP Metadata as a packet of XMP.
std::string xmp_of(const OIIO::ImageSpec &spec)
{
    std::string xmp = "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
                      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
                      "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
                      "<rdf:Description rdf:about=\"\"\n"
                      " xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"";
    for (const OIIO::ParamValue &value : spec.extra_attribs)
        if (OIIO::Strutil::starts_with(value.name(), "GPano:"))
            xmp += "\n " + value.name().string() + "=\"" + value.get_string() + "\"";
    return xmp + "/>\n</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"r\"?>";
}

void put_u32(std::string &to, size_t value)
{
    for (int shift = 24; shift >= 0; shift -= 8) to.push_back((char)(value >> shift));
}

// PNG has XMP in a chunk of international text (XMP specification, part 3, 1.1.5), which OpenImageIO does not
// write (2.5). The keyword is followed by: not compressed, method 0, no language, no translated keyword.
std::string png_xmp(const OIIO::ImageSpec &spec)
{
    const std::string body = "iTXtXML:com.adobe.xmp" + std::string(5, '\0') + xmp_of(spec);
    std::string chunk;
    put_u32(chunk, body.size() - 4);
    chunk += body;
    put_u32(chunk, crc32(0, (const Bytef *)body.data(), (uInt)body.size()));
    return chunk;
}

bool write_rows(OIIO::ImageOutput &out, rnd_pixels_source &source)
{
    const OIIO::ImageSpec &spec = out.spec();
    const size_t row = (size_t)spec.width * spec.nchannels;
    const int strip = strip_of(spec, row * sizeof(float));
    const std::unique_ptr<float[]> data(new float[strip * row]);
    for (int y = 0; y < spec.height; y += strip) {
        const int rows = std::min(strip, spec.height - y);
        source.rows(&source, y, rows, data.get());
        if (!out.write_scanlines(y, y + rows, 0, OIIO::TypeDesc::FLOAT, data.get())) return false;
    }
    return true;
}

} // namespace

extern "C" bool rnd_pixels_stream(const rnd_pixels_file *file, rnd_pixels_sink *sink, char *out_error,
                                  size_t error_size)
{
    const char *why = file->memory ? nullptr : rnd_why_closed(file->path);
    if (why) return fail(out_error, error_size, why);
    try {
        OIIO::Filesystem::IOMemReader reader(const_cast<void *>(file->memory), file->count);
        OIIO::Filesystem::IOProxy *proxy = &reader;
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        // Not as open()'s own argument, which its reader of JPEG does not look at (2.4.7).
        if (file->memory) config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
        auto in = OIIO::ImageInput::open(file->path, &config);
        if (!in) return fail(out_error, error_size, OIIO::geterror());
        const bool ok = read(*in, *file, *sink, out_error, error_size);
        in->close();
        return ok;
    } catch (const std::exception &e) {
        return fail(out_error, error_size, e.what());
    }
}

extern "C" bool rnd_pixels_read(const rnd_pixels_file *file, rnd_pixels *out_pixels, char *out_error,
                                size_t error_size)
{
    Keeper keeper = {{keep_begin, keep_rows}, out_pixels, 0};
    *out_pixels = rnd_pixels();
    if (rnd_pixels_stream(file, &keeper.sink, out_error, error_size)) return true;
    rnd_pixels_finish(out_pixels);
    return false;
}

extern "C" void rnd_pixels_finish(rnd_pixels *pixels)
{
    free(pixels->bytes);
    free(pixels->floats);
    *pixels = rnd_pixels();
}

extern "C" bool rnd_pixels_write(FILE *file, const rnd_layout *layout, rnd_pixels_source *source,
                                 char *out_error, size_t error_size)
{
    const std::string format = layout->format;
    try {
        Sink sink(file);
        OIIO::Filesystem::IOProxy *proxy = &sink;
        auto out = OIIO::ImageOutput::create(format);
        if (!out) return fail(out_error, error_size, OIIO::geterror());
        if (!out->supports("ioproxy"))
            return fail(out_error, error_size, "pictures are not written as ." + format);
        // libjpeg's JPEG_MAX_DIMENSION; beyond it the library ends the program.
        if (strcmp(out->format_name(), "jpeg") == 0 && std::max(layout->width, layout->height) > 65500)
            return fail(out_error, error_size, "a JPEG has at most 65500 pixels a side");
        OIIO::ImageSpec spec = spec_of(*layout);
        spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
        // It comes after the signature and the chunk IHDR, which are of fixed length.
        if (layout->equirectangular && strcmp(out->format_name(), "png") == 0)
            sink.insert(png_xmp(spec), 8 + 12 + 13);
        if (!out->open("x." + format, spec)) return fail(out_error, error_size, out->geterror());
        const bool ok = write_rows(*out, *source);
        const std::string text = ok ? "" : out->geterror();
        const bool closed = out->close();
        const int why = sink.finish();
        if (why != 0) return fail(out_error, error_size, strerror(why));
        return (ok && closed) || fail(out_error, error_size, text);
    } catch (const std::exception &e) {
        return fail(out_error, error_size, e.what());
    }
}
