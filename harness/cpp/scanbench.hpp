// A LiDAR object detector in C++17 as a detector of scanbench: docs/protocol.md, versions 1 and 2. No dependencies but POSIX.
//
//     int main() {
//         return scanbench::serve("mine", [](const scanbench::Configuration& configuration) {
//             const double eps = configuration.parameters.number("eps", 0.5);
//             return [eps](const scanbench::Cloud& cloud) {
//                 scanbench::Detections found;
//                 found.clusters.assign(cloud.n_points, 0);  // 0 is no cluster, clusters begin at 1
//                 …
//                 return found;
//             };
//         });
//     }
//
// Exceptions are reported to scanbench as errors, with their text; the next scan is asked for all the same. The function is called again
// where parameters or the data set change within a process.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iostream>
#include <limits>
#include <locale>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace scanbench {

// What goes wrong; any other std::exception is reported in the same way.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// A value of JSON.
class Json {
public:
    enum class Kind { null, boolean, number, string, array, object };

    Kind kind = Kind::null;
    bool boolean = false;
    double number = 0.0;
    std::string string;
    std::vector<Json> array;
    std::vector<std::pair<std::string, Json>> object;

    // Reads a whole text; throws Error if it is not JSON.
    static Json parse(std::string_view text);

    // The field `name` of an object, or null.
    const Json* field(std::string_view name) const {
        for (const auto& [key, value] : object) {
            if (key == name) return &value;
        }
        return nullptr;
    }
    // The field `name`; throws Error if there is none of this kind.
    const Json& need(std::string_view name, Kind wanted) const {
        const Json* value = field(name);
        if (value == nullptr || value->kind != wanted) {
            throw Error("field `" + std::string(name) + "` is missing or of another type");
        }
        return *value;
    }
    // The field `name` as a count; throws Error if it is none.
    std::uint64_t count(std::string_view name) const {
        const double value = need(name, Kind::number).number;
        if (!(value >= 0.0 && value <= 9007199254740992.0) || value != std::floor(value)) {
            throw Error("field `" + std::string(name) + "` is no count");
        }
        return static_cast<std::uint64_t>(value);
    }
    // The field `name` as text, or nothing where it is absent or null.
    std::optional<std::string> text(std::string_view name) const {
        const Json* value = field(name);
        if (value == nullptr || value->kind != Kind::string) return std::nullopt;
        return value->string;
    }

    // Fields of objects may come in another order.
    bool operator==(const Json& other) const {
        return kind == other.kind && boolean == other.boolean && !(number < other.number) && !(number > other.number) &&
               string == other.string && array == other.array &&
               std::is_permutation(object.begin(), object.end(), other.object.begin(), other.object.end());
    }

    // `text` between quotation marks.
    static std::string quoted(std::string_view text);
};

// The user's values. What is not asked for by the time the detector is configured is refused as unknown.
class Parameters {
public:
    Parameters() = default;
    explicit Parameters(Json values) : values_(std::move(values)) {}

    double number(const std::string& name, double otherwise) const {
        const Json* value = find(name, Json::Kind::number, "a number");
        return value ? value->number : otherwise;
    }
    long integer(const std::string& name, long otherwise) const {
        const Json* value = find(name, Json::Kind::number, "an integer");
        if (value == nullptr) return otherwise;
        if (value->number != std::floor(value->number) || std::abs(value->number) > 9007199254740992.0) {
            throw Error("parameter `" + name + "` is not an integer");
        }
        return static_cast<long>(value->number);
    }
    bool flag(const std::string& name, bool otherwise) const {
        const Json* value = find(name, Json::Kind::boolean, "true or false");
        return value ? value->boolean : otherwise;
    }
    std::string text(const std::string& name, const std::string& otherwise) const {
        const Json* value = find(name, Json::Kind::string, "text");
        return value ? value->string : otherwise;
    }
    // Throws Error if there is a parameter that nobody has asked for.
    void refuse_unknown() const {
        for (const auto& [name, value] : values_.object) {
            if (known_.count(name) == 0) throw Error("unknown parameter `" + name + "`; there are" + all_known());
        }
    }

private:
    const Json* find(const std::string& name, Json::Kind wanted, const char* what) const {
        known_.insert(name);
        const Json* value = values_.field(name);
        if (value != nullptr && value->kind != wanted) throw Error("parameter `" + name + "` is not " + what);
        return value;
    }
    std::string all_known() const {
        std::string names;
        for (const auto& name : known_) names += " " + name;
        return names.empty() ? " none" : names;
    }

    Json values_;
    mutable std::set<std::string> known_;
};

// What scanbench says before the first scan.
struct Configuration {
    std::string dataset;
    std::optional<std::string> sensor;
    std::optional<double> sensor_height_m;
    std::size_t threads = 1;
    Parameters parameters;

    // Asks for so many scans before each one (Cloud::earlier), and for the scans of a drive one after the other, each once.
    void look_back(std::size_t n_earlier_scans, bool scans_in_order = false) const {
        earlier_scans = n_earlier_scans;
        in_order = scans_in_order;
    }
    mutable std::size_t earlier_scans = 0;
    mutable bool in_order = false;
};

// The points of a scan as columns, in the sensor frame: x forward, y left, z up. Valid until the detector returns.
struct Cloud {
    std::uint64_t number = 0;
    std::string name;
    double time_s = 0.0;
    std::size_t n_points = 0;
    const float* x_m = nullptr;
    const float* y_m = nullptr;
    const float* z_m = nullptr;
    // Null where the data have none.
    const float* intensity = nullptr;
    const std::uint16_t* ring = nullptr;
    const float* time_offset_s = nullptr;
    // Pose of the sensor in a frame that rests: three rows of four numbers, the turn and the position.
    std::optional<std::array<double, 12>> world_from_sensor;
    // The scans before this one, the latest first, in the frame of this one: see Configuration::look_back.
    std::vector<Cloud> earlier;
    // Whether a detector that wants scans in order has to forget what it knows.
    bool begins_drive = false;
};

// An upright box: centre, length along the heading, width, height, and the heading counter-clockwise from x.
struct Box {
    float x_m, y_m, z_m, length_m, width_m, height_m, yaw_rad;
};

// Velocity over ground along x and y of the scan, in metres per second; NaN where it is not known.
struct Velocity {
    float x_m_per_s, y_m_per_s;
};

// The track of what is on none.
constexpr std::uint32_t NO_TRACK = std::numeric_limits<std::uint32_t>::max();

struct Stage {
    std::string name;
    double ms;
};

// A value for each point, drawn as a colour by the viewer.
struct Product {
    std::string name;
    std::vector<std::uint8_t> labels;
};

// What was found. Clusters alone, boxes alone, or both: then box k (from 0) is that of cluster k + 1.
struct Detections {
    std::vector<std::uint32_t> clusters;  // empty, or an id for each point: 0 is none, clusters begin at 1
    std::vector<Box> boxes;
    std::vector<float> scores;                         // empty, or one for each detection
    std::vector<std::optional<std::string>> classes;   // empty, or one for each detection
    std::vector<Velocity> velocities;                  // empty, or one for each detection
    std::vector<std::uint32_t> tracks;                 // empty, or one for each detection
    std::vector<Stage> stages;
    std::vector<Product> products;
    bool has_clusters = true;  // false: boxes alone
};

using Detect = std::function<Detections(const Cloud&)>;
using Configure = std::function<Detect(const Configuration&)>;

// Takes the times of stages one after the other: each call ends the stage that has run since the last.
class StageClock {
public:
    void end(std::string name) {
        const auto now = std::chrono::steady_clock::now();
        stages_.push_back({std::move(name), std::chrono::duration<double, std::milli>(now - last_).count()});
        last_ = now;
    }
    std::vector<Stage> stages() const { return stages_; }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
    std::vector<Stage> stages_;
};

namespace inner {

constexpr std::size_t MAX_LINE_BYTES = 1 << 20;

// Reads JSON; `depth` keeps hostile nesting from the stack.
class Reader {
public:
    explicit Reader(std::string_view text) : text_(text) {}

    Json whole() {
        Json value = any(0);
        space();
        if (at_ != text_.size()) fail();
        return value;
    }

private:
    [[noreturn]] void fail() const { throw Error("not JSON at byte " + std::to_string(at_)); }
    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    void space() {
        while (at_ < text_.size() && std::strchr(" \t\r\n", text_[at_]) != nullptr && text_[at_] != '\0') ++at_;
    }
    bool take(char wanted) {
        space();
        if (peek() != wanted || at_ >= text_.size()) return false;
        ++at_;
        return true;
    }
    void word(std::string_view wanted) {
        if (text_.substr(at_, wanted.size()) != wanted) fail();
        at_ += wanted.size();
    }
    Json any(int depth) {
        if (depth > 64) fail();
        space();
        Json value;
        switch (peek()) {
            case '{': object(value, depth); break;
            case '[': array(value, depth); break;
            case '"': value.kind = Json::Kind::string; value.string = string(); break;
            case 't': word("true"); value.kind = Json::Kind::boolean; value.boolean = true; break;
            case 'f': word("false"); value.kind = Json::Kind::boolean; break;
            case 'n': word("null"); break;
            default: value.kind = Json::Kind::number; value.number = number();
        }
        return value;
    }
    void object(Json& value, int depth) {
        value.kind = Json::Kind::object;
        take('{');
        if (take('}')) return;
        do {
            space();
            std::string key = string();
            if (!take(':')) fail();
            value.object.emplace_back(std::move(key), any(depth + 1));
        } while (take(','));
        if (!take('}')) fail();
    }
    void array(Json& value, int depth) {
        value.kind = Json::Kind::array;
        take('[');
        if (take(']')) return;
        do {
            value.array.push_back(any(depth + 1));
        } while (take(','));
        if (!take(']')) fail();
    }
    double number() {
        const std::size_t start = at_;
        while (at_ < text_.size() && std::strchr("+-.eE0123456789", text_[at_]) != nullptr && text_[at_] != '\0') ++at_;
        // Not strtod, which reads as the program's locale writes.
        std::istringstream stream{std::string(text_.substr(start, at_ - start))};
        stream.imbue(std::locale::classic());
        double value = 0.0;
        if (at_ == start || !(stream >> value) || stream.peek() != std::istringstream::traits_type::eof()) fail();
        return value;
    }
    std::string string() {
        if (peek() != '"') fail();
        ++at_;
        std::string text;
        while (peek() != '"') {
            if (at_ >= text_.size()) fail();
            if (text_[at_] == '\\') {
                ++at_;
                escape(text);
            } else {
                text += text_[at_++];
            }
        }
        ++at_;
        return text;
    }
    void escape(std::string& text) {
        static constexpr std::string_view letters = "\"\\/bfnrt", meant = "\"\\/\b\f\n\r\t";
        const char letter = peek();
        ++at_;
        if (letter == 'u') {
            unicode(text);
            return;
        }
        const std::size_t place = letters.find(letter);
        if (place == std::string_view::npos || letter == '\0') fail();
        text += meant[place];
    }
    unsigned hex() {
        unsigned value = 0;
        for (int digit = 0; digit < 4; ++digit, ++at_) {
            static constexpr std::string_view digits = "0123456789abcdef";
            const char letter = peek() >= 'A' && peek() <= 'F' ? static_cast<char>(peek() - 'A' + 'a') : peek();
            const std::size_t place = digits.find(letter);
            if (place == std::string_view::npos) fail();
            value = 16 * value + static_cast<unsigned>(place);
        }
        return value;
    }
    void unicode(std::string& text) {
        unsigned code = hex();
        if (code >= 0xD800 && code < 0xDC00) {
            word("\\u");
            const unsigned low = hex();
            if (low < 0xDC00 || low > 0xDFFF) fail();
            code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
        }
        if (code < 0x80) {
            text += static_cast<char>(code);
            return;
        }
        const int n_more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
        static constexpr std::array<unsigned, 4> lead = {0, 0xC0, 0xE0, 0xF0};
        text += static_cast<char>(lead[n_more] | (code >> (6 * n_more)));
        for (int left = n_more - 1; left >= 0; --left) text += static_cast<char>(0x80 | ((code >> (6 * left)) & 0x3F));
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

// The pair of pipes.
class Pipe {
public:
    Pipe(int read_fd, int write_fd) : read_fd_(read_fd), write_fd_(write_fd) {
        fcntl(read_fd, F_SETFD, FD_CLOEXEC);
        fcntl(write_fd, F_SETFD, FD_CLOEXEC);
    }

    // The next message, or nothing at the end of the file.
    std::optional<Json> read() {
        std::size_t end;
        while ((end = buffer_.find('\n')) == std::string::npos) {
            if (buffer_.size() >= MAX_LINE_BYTES) throw Error("a line is longer than 1 MiB");
            if (!fill()) {
                if (buffer_.empty()) return std::nullopt;
                throw Error("a line is cut off");
            }
        }
        Json message = Json::parse(std::string_view(buffer_).substr(0, end));
        buffer_.erase(0, end + 1);
        if (message.kind != Json::Kind::object) throw Error("a line is not a JSON object");
        message.need("message", Json::Kind::string);
        skip_payload(message.field("payload_bytes") != nullptr ? message.count("payload_bytes") : 0);
        return message;
    }

    // Sends a line, which has no end yet, and a payload; false if the host is gone.
    bool write(std::string line, const std::vector<std::string_view>& payload = {}) const {
        line += '\n';
        if (line.size() > MAX_LINE_BYTES) throw Error("the line of the answer is longer than 1 MiB");
        if (!write_all(line)) return false;
        for (const auto& part : payload) {
            if (!write_all(part)) return false;
        }
        return true;
    }

private:
    bool fill() {
        std::array<char, 65536> data;
        ssize_t n;
        do {
            n = ::read(read_fd_, data.data(), data.size());
        } while (n < 0 && errno == EINTR);
        if (n <= 0) return false;
        buffer_.append(data.data(), static_cast<std::size_t>(n));
        return true;
    }
    void skip_payload(std::uint64_t n_bytes) {
        while (n_bytes > buffer_.size()) {
            n_bytes -= buffer_.size();
            buffer_.clear();
            if (!fill()) return;
        }
        buffer_.erase(0, static_cast<std::size_t>(n_bytes));
    }
    bool write_all(std::string_view data) const {
        while (!data.empty()) {
            const ssize_t n = ::write(write_fd_, data.data(), data.size());
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) return false;
            data.remove_prefix(static_cast<std::size_t>(n));
        }
        return true;
    }

    int read_fd_, write_fd_;
    std::string buffer_;
};

// The file that scans are in, mapped for reading.
class SharedMemory {
public:
    explicit SharedMemory(const std::string& path) {
        const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
        if (descriptor < 0) throw Error("cannot open " + path + ": " + std::strerror(errno));
        struct stat status {};
        if (fstat(descriptor, &status) == 0 && status.st_size > 0) {
            size_ = static_cast<std::size_t>(status.st_size);
            data_ = mmap(nullptr, size_, PROT_READ, MAP_SHARED, descriptor, 0);
        }
        ::close(descriptor);
        if (data_ == MAP_FAILED) throw Error("cannot map " + path + ": " + std::strerror(errno));
    }
    SharedMemory(const SharedMemory&) = delete;
    SharedMemory& operator=(const SharedMemory&) = delete;
    ~SharedMemory() {
        if (data_ != nullptr && data_ != MAP_FAILED) munmap(data_, size_);
    }

    // `n` values from byte `offset`; throws Error if the file ends before.
    template <typename T>
    const T* column(std::uint64_t offset, std::size_t n) const {
        if (offset % alignof(T) != 0 || offset > size_ || n > (size_ - offset) / sizeof(T)) {
            throw Error("a column lies beyond the shared memory");
        }
        return reinterpret_cast<const T*>(static_cast<const char*>(data_) + offset);
    }

private:
    void* data_ = nullptr;
    std::size_t size_ = 0;
};

template <typename T>
std::string_view bytes(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Three digits after the point, whatever the locale; at most what scanbench takes.
inline std::string milliseconds(double ms) {
    const auto micros = static_cast<long long>(ms > 0.0 ? std::min(ms, 999999999.0) * 1000.0 + 0.5 : 0.0);
    const std::string rest = std::to_string(micros % 1000);
    return std::to_string(micros / 1000) + "." + std::string(3 - rest.size(), '0') + rest;
}

inline std::size_t n_different(const std::vector<std::uint32_t>& ids) {
    std::set<std::uint32_t> seen;
    std::uint32_t last = 0;
    for (const std::uint32_t id : ids) {
        if (id != 0 && id != last) seen.insert(last = id);
    }
    return seen.size();
}

inline bool is_sound(const Box& box) {
    for (const float value : {box.x_m, box.y_m, box.z_m, box.length_m, box.width_m, box.height_m, box.yaw_rad}) {
        if (!std::isfinite(value)) return false;
    }
    for (const float size_m : {box.length_m, box.width_m, box.height_m}) {
        if (!(size_m > 0.0F && size_m <= 1000.0F)) return false;
    }
    return std::hypot(std::hypot(double{box.x_m}, double{box.y_m}), double{box.z_m}) <= 10000.0;
}

// Throws Error if no stage or product may be called so.
inline void check_name(const std::string& name) {
    bool is_name = !name.empty() && name.size() <= 60;
    for (const char letter : name) is_name = is_name && static_cast<unsigned char>(letter) >= 0x20 && letter != '\x7f';
    if (!is_name) throw Error("`" + name + "` is no name of a stage or product: 1 to 60 bytes, no control characters");
}

// How many detections the answer has; throws Error where scanbench would refuse it.
inline std::size_t check(const Detections& found, std::size_t n_points) {
    const auto number = [](std::size_t n) { return std::to_string(n); };
    std::size_t n_detections = found.boxes.size();
    if (found.has_clusters) {
        if (found.clusters.size() != n_points) {
            throw Error(number(found.clusters.size()) + " cluster ids for " + number(n_points) + " points");
        }
        std::uint32_t largest = 0;
        for (const std::uint32_t id : found.clusters) largest = id > largest ? id : largest;
        if (found.boxes.empty()) {
            n_detections = n_different(found.clusters);
        } else if (largest != found.boxes.size()) {
            throw Error(number(found.boxes.size()) + " boxes for clusters up to number " + number(largest));
        }
    } else if (!found.clusters.empty()) {
        throw Error("cluster ids, and has_clusters is false");
    }
    if (found.boxes.size() > 100000) throw Error(number(found.boxes.size()) + " boxes, more than 100000");
    if (found.products.size() > 32) throw Error(number(found.products.size()) + " products, more than 32");
    for (const auto& stage : found.stages) check_name(stage.name);
    for (std::size_t box_idx = 0; box_idx < found.boxes.size(); ++box_idx) {
        if (!is_sound(found.boxes[box_idx])) throw Error("box " + number(box_idx) + " is not finite, or has an absurd size or place");
    }
    if (!found.scores.empty() && found.scores.size() != n_detections) {
        throw Error(number(found.scores.size()) + " scores for " + number(n_detections) + " detections");
    }
    for (const float score : found.scores) {
        if (!std::isfinite(score)) throw Error("a score is not a finite number");
    }
    if (!found.classes.empty() && found.classes.size() != n_detections) {
        throw Error(number(found.classes.size()) + " classes for " + number(n_detections) + " detections");
    }
    if (!found.velocities.empty() && found.velocities.size() != n_detections) {
        throw Error(number(found.velocities.size()) + " velocities for " + number(n_detections) + " detections");
    }
    for (const auto& [x_m_per_s, y_m_per_s] : found.velocities) {
        const bool is_known = std::abs(x_m_per_s) <= 1000.0F && std::abs(y_m_per_s) <= 1000.0F;
        if (!is_known && !(std::isnan(x_m_per_s) && std::isnan(y_m_per_s))) {
            throw Error("a velocity is known along one axis alone, or above 1000 m/s");
        }
    }
    if (!found.tracks.empty() && found.tracks.size() != n_detections) {
        throw Error(number(found.tracks.size()) + " tracks for " + number(n_detections) + " detections");
    }
    for (const auto& product : found.products) {
        check_name(product.name);
        if (product.labels.size() != n_points) throw Error("product `" + product.name + "` has another length than the scan");
    }
    return n_detections;
}

// The elements of a list, with commas between.
template <typename T, typename F>
std::string list(const std::vector<T>& items, F text_of) {
    std::string text = "[";
    for (const auto& item : items) text += (text.size() > 1 ? "," : "") + text_of(item);
    return text + "]";
}

inline std::string result_line(const Detections& found, std::uint64_t number, std::size_t n_bytes) {
    std::string line = "{\"message\":\"result\",\"number\":" + std::to_string(number);
    if (found.has_clusters) line += ",\"clusters\":true";
    if (!found.boxes.empty()) line += ",\"n_boxes\":" + std::to_string(found.boxes.size());
    if (!found.scores.empty()) line += ",\"scores\":true";
    if (!found.velocities.empty()) line += ",\"velocities\":true";
    if (!found.tracks.empty()) line += ",\"tracks\":true";
    if (!found.classes.empty()) {
        line += ",\"classes\":" + list(found.classes, [](const std::optional<std::string>& name) {
                    return name ? Json::quoted(*name) : std::string("null");
                });
    }
    if (!found.stages.empty()) {
        line += ",\"stages\":" + list(found.stages, [](const Stage& stage) {
                    return "{\"name\":" + Json::quoted(stage.name) + ",\"ms\":" + milliseconds(stage.ms) + "}";
                });
    }
    if (!found.products.empty()) {
        line += ",\"products\":" + list(found.products, [](const Product& product) {
                    return "{\"name\":" + Json::quoted(product.name) + ",\"kind\":\"point-labels\",\"type\":\"u8\"}";
                });
    }
    return line + ",\"payload_bytes\":" + std::to_string(n_bytes) + "}";
}

inline std::string error_line(std::string_view text) {
    return "{\"message\":\"error\",\"text\":" + Json::quoted(text) + "}";
}

// What outlives a message.
class Session {
public:
    Session(std::string name, Configure configure, std::string version)
        : name_(std::move(name)), version_(std::move(version)), configure_(std::move(configure)) {}

    bool has_ended = false;

    // Answers a message; false if the host is gone.
    bool answer(const Pipe& pipe, const Json& message) {
        const std::string& kind = message.need("message", Json::Kind::string).string;
        if (kind == "hello") return pipe.write(hello(message));
        if (kind == "configure") return pipe.write(configure(message));
        if (kind == "scan") return scan(pipe, message);
        throw Error("unknown message " + Json::quoted(kind));
    }

private:
    std::string hello(const Json& message) {
        if (message.count("protocol") != 1) {
            has_ended = true;
            throw Error("protocol " + std::to_string(message.count("protocol")) + " is not known, only 1 and 2");
        }
        protocol_ = 1;
        if (const Json* all = message.field("protocols")) {
            for (const Json& it : all->array) protocol_ = it.number == 2.0 ? 2 : protocol_;
        }
        std::string line =
            "{\"message\":\"hello\",\"protocol\":" + std::to_string(protocol_) + ",\"name\":" + Json::quoted(name_);
        if (!version_.empty()) line += ",\"version\":" + Json::quoted(version_);
        return line + "}";
    }
    std::string configure(const Json& message) {
        // Nothing that was configured before counts: if anything fails now, nothing is configured.
        Detect detect = std::exchange(detect_, nullptr);
        const Json last = std::exchange(configuration_, Json());
        memory_.reset();
        memory_ = std::make_unique<SharedMemory>(message.need("shared_memory", Json::Kind::string).string);
        if (!detect || !is_same(message, last)) {
            // What the last one holds is free before the next one is made.
            detect = nullptr;
            const Configuration configuration = configuration_of(message);
            detect = configure_(configuration);
            configuration.parameters.refuse_unknown();
            wishes_.clear();
            if (configuration.earlier_scans > 0) wishes_ += ",\"earlier_scans\":" + std::to_string(configuration.earlier_scans);
            if (configuration.in_order) wishes_ += ",\"in_order\":true";
            if (!wishes_.empty() && protocol_ < 2) throw Error(name_ + " looks back at its drive, which this scanbench does not know");
        }
        // Else it is for larger memory alone: the detector keeps its state.
        detect_ = std::move(detect);
        configuration_ = message;
        return "{\"message\":\"configured\"" + wishes_ + "}";
    }
    static bool is_same(const Json& message, const Json& last) {
        for (const char* name : {"dataset", "sensor", "sensor_height_m", "parameters", "threads"}) {
            const Json *now = message.field(name), *before = last.field(name);
            if (now == nullptr || before == nullptr ? now != before : !(*now == *before)) return false;
        }
        return true;
    }
    static Configuration configuration_of(const Json& message) {
        Configuration configuration;
        configuration.dataset = message.text("dataset").value_or("");
        configuration.sensor = message.text("sensor");
        const Json* height_m = message.field("sensor_height_m");
        if (height_m != nullptr && height_m->kind == Json::Kind::number) configuration.sensor_height_m = height_m->number;
        if (message.field("threads") != nullptr) configuration.threads = static_cast<std::size_t>(message.count("threads"));
        const Json* parameters = message.field("parameters");
        if (parameters != nullptr) configuration.parameters = Parameters(*parameters);
        return configuration;
    }
    bool scan(const Pipe& pipe, const Json& message) {
        if (!detect_) throw Error("a scan before `configure`");
        const Cloud cloud = cloud_of(message);
        Detections found = detect_(cloud);
        check(found, cloud.n_points);
        if (protocol_ < 2) {
            found.velocities.clear();
            found.tracks.clear();
        }
        std::vector<std::string_view> payload = {
            bytes(found.clusters), bytes(found.boxes), bytes(found.scores), bytes(found.velocities), bytes(found.tracks)};
        for (const auto& product : found.products) payload.push_back(bytes(product.labels));
        std::size_t n_bytes = 0;
        for (const auto& part : payload) n_bytes += part.size();
        return pipe.write(result_line(found, cloud.number, n_bytes), payload);
    }
    Cloud cloud_of(const Json& message) const {
        Cloud cloud = columns_of(message);
        cloud.number = message.count("number");
        if (protocol_ < 2) return cloud;
        const Json* begins_drive = message.field("begins_drive");
        cloud.begins_drive = begins_drive != nullptr && begins_drive->boolean;
        const Json* pose = message.field("world_from_sensor");
        if (pose != nullptr && pose->array.size() == 12) {
            cloud.world_from_sensor.emplace();
            for (std::size_t idx = 0; idx < 12; ++idx) (*cloud.world_from_sensor)[idx] = pose->array[idx].number;
        }
        if (const Json* earlier = message.field("earlier")) {
            for (const Json& it : earlier->array) cloud.earlier.push_back(columns_of(it));
            for (Cloud& it : cloud.earlier) it.number = cloud.number;
        }
        return cloud;
    }
    Cloud columns_of(const Json& message) const {
        Cloud cloud;
        cloud.name = message.text("name").value_or("");
        const Json* time_s = message.field("time_s");
        if (time_s != nullptr) cloud.time_s = time_s->number;
        cloud.n_points = static_cast<std::size_t>(message.count("n_points"));
        for (const Json& column : message.need("columns", Json::Kind::array).array) {
            const std::string& name = column.need("name", Json::Kind::string).string;
            const std::uint64_t offset = column.count("offset");
            const float** values = name == "x_m"             ? &cloud.x_m
                                   : name == "y_m"           ? &cloud.y_m
                                   : name == "z_m"           ? &cloud.z_m
                                   : name == "intensity"     ? &cloud.intensity
                                   : name == "time_offset_s" ? &cloud.time_offset_s
                                                             : nullptr;
            if (values != nullptr) *values = memory_->column<float>(offset, cloud.n_points);
            if (name == "ring") cloud.ring = memory_->column<std::uint16_t>(offset, cloud.n_points);
        }
        if (cloud.x_m == nullptr || cloud.y_m == nullptr || cloud.z_m == nullptr) throw Error("a scan without x_m, y_m, z_m");
        return cloud;
    }

    std::string name_, version_, wishes_;
    std::uint64_t protocol_ = 1;
    Configure configure_;
    Detect detect_;
    Json configuration_;  // the message
    std::unique_ptr<SharedMemory> memory_;
};

inline int descriptor(const char* name) {
    const char* text = std::getenv(name);
    return text != nullptr && *text != '\0' ? std::atoi(text) : -1;
}

}  // namespace inner

inline Json Json::parse(std::string_view text) { return inner::Reader(text).whole(); }

inline std::string Json::quoted(std::string_view text) {
    static constexpr std::string_view digits = "0123456789abcdef";
    std::string quoted = "\"";
    for (const char letter : text) {
        const auto code = static_cast<unsigned char>(letter);
        if (letter == '"' || letter == '\\') {
            quoted += '\\';
            quoted += letter;
        } else if (code < 0x20) {
            quoted += "\\u00";
            quoted += digits[code >> 4];
            quoted += digits[code & 15];
        } else {
            quoted += letter;
        }
    }
    return quoted + "\"";
}

// Answers scanbench until it says *quit* or is gone; returns the exit code of main.
inline int serve(const std::string& name, Configure configure, const std::string& version = "") {
    static_assert(sizeof(Box) == 28 && std::numeric_limits<float>::is_iec559, "boxes are sent as they lie in memory");
    const int read_fd = inner::descriptor("SCANBENCH_READ_FD"), write_fd = inner::descriptor("SCANBENCH_WRITE_FD");
    if (read_fd < 0 || write_fd < 0) {
        std::cerr << "This is a detector: scanbench starts it. Name it in scanbench.toml,\n\n    [detector." << name
                  << "]\n    command = [\"…\"]\n\nand run: scanbench run -d " << name << "\n";
        return 2;
    }
    // A host that is gone is the end, and no reason to die of a signal.
    std::signal(SIGPIPE, SIG_IGN);
    inner::Pipe pipe(read_fd, write_fd);
    inner::Session session(name, std::move(configure), version);
    while (true) {
        std::optional<Json> message;
        try {
            message = pipe.read();
        } catch (const Error& error) {
            pipe.write(inner::error_line(error.what()));
            return 1;
        }
        if (!message || message->field("message")->string == "quit") return 0;
        try {
            if (!session.answer(pipe, *message)) return 0;
        } catch (const std::exception& error) {
            std::cerr << "error: " << error.what() << std::endl;
            if (!pipe.write(inner::error_line(error.what()))) return 0;
        }
        if (session.has_ended) return 1;
    }
}

}  // namespace scanbench
