#include "mesh/image_file.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "elastin/core/base/error.h"
#include "elastin/core/base/text.h"
#include "elastin/core/base/units.h"
#include "mesh/text_file.h"

namespace elastin::mesh {
namespace {

using Number = Image::Number;

constexpr double kMostVoxels = 2147483647;
constexpr const char* kSeveralFiles = "has its data in several files; needed: one, as .nrrd and .mha have it";

struct NumberName {
  const char* name;
  Number number;
};
/// The names that NRRD and MetaImage have, and the codes of NIfTI.
constexpr NumberName kNrrd[] = {{"signed char", Number::int8},
                                {"int8", Number::int8},
                                {"int8_t", Number::int8},
                                {"uchar", Number::uint8},
                                {"unsigned char", Number::uint8},
                                {"uint8", Number::uint8},
                                {"uint8_t", Number::uint8},
                                {"short", Number::int16},
                                {"short int", Number::int16},
                                {"signed short", Number::int16},
                                {"int16", Number::int16},
                                {"int16_t", Number::int16},
                                {"ushort", Number::uint16},
                                {"unsigned short", Number::uint16},
                                {"unsigned short int", Number::uint16},
                                {"uint16", Number::uint16},
                                {"uint16_t", Number::uint16},
                                {"int", Number::int32},
                                {"signed int", Number::int32},
                                {"int32", Number::int32},
                                {"int32_t", Number::int32},
                                {"uint", Number::uint32},
                                {"unsigned int", Number::uint32},
                                {"uint32", Number::uint32},
                                {"uint32_t", Number::uint32},
                                {"longlong", Number::int64},
                                {"long long", Number::int64},
                                {"int64", Number::int64},
                                {"int64_t", Number::int64},
                                {"ulonglong", Number::uint64},
                                {"unsigned long long", Number::uint64},
                                {"uint64", Number::uint64},
                                {"uint64_t", Number::uint64},
                                {"float", Number::float32},
                                {"double", Number::float64}};
constexpr NumberName kMeta[] = {
    {"MET_CHAR", Number::int8},         {"MET_UCHAR", Number::uint8},   {"MET_SHORT", Number::int16},
    {"MET_USHORT", Number::uint16},     {"MET_INT", Number::int32},     {"MET_UINT", Number::uint32},
    {"MET_LONG", Number::int32},        {"MET_ULONG", Number::uint32},  {"MET_LONG_LONG", Number::int64},
    {"MET_ULONG_LONG", Number::uint64}, {"MET_FLOAT", Number::float32}, {"MET_DOUBLE", Number::float64}};
constexpr NumberName kNumpy[] = {{"i1", Number::int8},    {"u1", Number::uint8},  {"b1", Number::uint8},
                                 {"i2", Number::int16},   {"u2", Number::uint16}, {"i4", Number::int32},
                                 {"u4", Number::uint32},  {"i8", Number::int64},  {"u8", Number::uint64},
                                 {"f4", Number::float32}, {"f8", Number::float64}};
struct NiftiNumber {
  int code;
  Number number;
};
constexpr NiftiNumber kNifti[] = {
    {2, Number::uint8},  {4, Number::int16},    {8, Number::int32},    {16, Number::float32}, {64, Number::float64},
    {256, Number::int8}, {512, Number::uint16}, {768, Number::uint32}, {1024, Number::int64}, {1280, Number::uint64}};

std::size_t bytes_of(Number number) {
  constexpr std::size_t bytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return bytes[static_cast<std::size_t>(number)];
}

template <class T>
T number_at(const char* data, bool swapped) {
  std::array<char, sizeof(T)> bytes;
  std::copy_n(data, sizeof(T), bytes.begin());
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// One image file, and the file with its data.
class ImageReader {
 public:
  ImageReader(const std::string& path, const std::function<void(const ImageGrid&)>& check)
      : path_(path), check_(check) {}
  Image read_nifti();
  Image read_nrrd();
  Image read_meta();
  Image read_numpy();

 private:
  [[noreturn]] void fail(const std::string& message) const { throw InputError(path_ + ": " + message); }
  std::string load(const std::string& path) const {
    try {
      return path == path_ ? format::load_file(path).bytes : format::load_bytes(path);
    } catch (const InputError& error) {
      if (path == path_) throw;
      fail(std::string("its data: ") + error.what());
    }
  }
  /// A data file that the header names, next to it.
  std::string path_next_to(const std::string& name) const {
    return name.starts_with('/') ? name : path_.substr(0, path_.rfind('/') + 1) + name;
  }
  std::string unpacked(std::string_view packed, std::size_t wanted, bool whole = true) const;
  Number number_named(std::span<const NumberName> table, const std::string& name) const;
  std::vector<double> numbers(const std::string& text, const std::string& key) const;
  double count(const std::string& text, const std::string& key) const;
  std::vector<std::size_t> sizes(const std::string& text, const std::string& key) const;
  /// Of `"mm" "mm" "mm"` [m]; 0: none that is known.
  double unit_of(const std::string& text, const std::string& key) const;
  void set_size(Image& image, std::vector<std::size_t> sizes) const;
  std::size_t data_bytes(const Image& image) const { return image.voxels() * bytes_of(image.number); }
  void set_data(Image& image, std::string_view bytes) const;
  void set_text(Image& image, std::string_view text) const;

  /// Of a header that is read, before its data.
  void check(const Image& image) const;

  std::string path_;
  const std::function<void(const ImageGrid&)>& check_;
};

/// The first `wanted` bytes of what gzip or zlib has packed; memory grows with what comes out. Of the `whole` of it the
/// checksum is compared, and what more is packed comes along, up to as much again, so that its size can be checked.
std::string ImageReader::unpacked(std::string_view packed, std::size_t wanted, bool whole) const {
  std::string result;
  z_stream stream{};
  constexpr int any_header = 15 + 32;  // zlib.h: inflateInit2
  if (inflateInit2(&stream, any_header) != Z_OK) fail("zlib cannot start");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  const std::size_t most = whole ? 2 * wanted + 1 : wanted;
  int code = Z_OK;
  bool again = false;  // several may stand one after the other
  while (code == Z_OK && result.size() < most) {
    const auto used = static_cast<std::size_t>(reinterpret_cast<const char*>(stream.next_in) - packed.data());
    stream.avail_in = static_cast<uInt>(std::min<std::size_t>(packed.size() - used, UINT32_MAX));
    const std::size_t before = result.size(), more = std::min<std::size_t>(most - before, 1 << 20);
    result.resize(before + more);
    stream.next_out = reinterpret_cast<Bytef*>(result.data() + before);
    stream.avail_out = static_cast<uInt>(more);
    code = inflate(&stream, Z_NO_FLUSH);
    result.resize(before + more - stream.avail_out);
    if (again && code < 0 && stream.total_out == 0)
      code = Z_STREAM_END;  // padding, which gzip ignores
    else if (code == Z_STREAM_END && stream.avail_in > 0 && result.size() < wanted && inflateReset(&stream) == Z_OK)
      code = Z_OK, again = true;
  }
  const std::string reason = stream.msg ? std::string(" (") + stream.msg + ")" : "";
  inflateEnd(&stream);
  if (code != Z_STREAM_END && (code != Z_OK || result.size() < wanted))
    fail("its packed data end early or are damaged" + reason + ", after " + std::to_string(result.size()) +
         " bytes; copy the file again");
  return result;
}

Number ImageReader::number_named(std::span<const NumberName> table, const std::string& name) const {
  for (const NumberName& row : table)
    if (row.name == name) return row.number;
  std::vector<std::string> read;  // the first name of each
  for (const NumberName& row : table)
    if (&row == table.data() || (&row)[-1].number != row.number) read.push_back(row.name);
  fail("has numbers of type '" + name + "'; those that are read: " + listed(read));
}

std::vector<double> ImageReader::numbers(const std::string& text, const std::string& key) const {
  std::vector<double> result;
  const char *at = text.data(), *end = at + text.size();
  while (true) {
    while (at != end && (std::isspace(static_cast<unsigned char>(*at)) || *at == ',' || *at == '(' || *at == ')')) ++at;
    if (at == end) return result;
    double value = 0;
    if (*at == '+') ++at;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) fail("'" + key + "' has no finite number in '" + text + "'");
    result.push_back(value);
    at = next;
  }
}

double ImageReader::count(const std::string& text, const std::string& key) const {
  const std::vector<double> all = numbers(text, key);
  if (all.size() != 1) fail("'" + key + "' is '" + text + "'; needed: one number");
  return all[0];
}

std::vector<std::size_t> ImageReader::sizes(const std::string& text, const std::string& key) const {
  std::vector<std::size_t> result;
  for (const double value : numbers(text, key)) {
    if (!(value >= 1) || value > kMostVoxels || value != std::floor(value))
      fail("'" + key + "' is '" + text + "'; needed: whole numbers from 1");
    result.push_back(value);
  }
  return result;
}

void ImageReader::set_size(Image& image, std::vector<std::size_t> sizes) const {
  while (sizes.size() > 3 && sizes.back() == 1) sizes.pop_back();
  double voxels = 1;
  for (const std::size_t size : sizes) voxels *= static_cast<double>(size);
  if (sizes.size() != 3)
    fail("has " + std::to_string(sizes.size()) + " dimensions; needed: three, one number a voxel" +
         (sizes.size() > 3 ? " (choose one time, channel or component before)" : ""));
  if (voxels > kMostVoxels) fail("claims " + number(voxels) + " voxels; at most " + number(kMostVoxels) + " are read");
  for (int axis = 0; axis < 3; ++axis) image.size[axis] = static_cast<int>(sizes[axis]);
  image.strides = {1, sizes[0], sizes[0] * sizes[1]};
}

void ImageReader::check(const Image& image) const {
  const double volume = image.steps.determinant(), sides = image.steps.colwise().norm().prod();
  if (!image.steps.allFinite() || !image.origin.allFinite() || !(std::abs(volume) > 1e-6 * sides))
    fail("its voxels have no volume: spacings and directions must be finite, not zero and not in one plane");
  if (!std::isfinite(image.slope) || !std::isfinite(image.intercept)) fail("its scale of values is not finite");
  if (check_) check_(image);
}

void ImageReader::set_data(Image& image, std::string_view bytes) const {
  const std::size_t needed = data_bytes(image);
  // Some programs pad files; a header that is wrong misses a slice or more.
  const std::size_t slice = needed / image.size[2];
  if (bytes.size() < needed || bytes.size() - needed >= slice)
    fail("has " + std::to_string(bytes.size()) + " bytes of data; its header says " + std::to_string(image.size[0]) +
         " x " + std::to_string(image.size[1]) + " x " + std::to_string(image.size[2]) + " voxels, " +
         std::to_string(needed) + " bytes");
  image.data = std::string(bytes.substr(0, needed));
}

/// Data written as text, as real numbers.
void ImageReader::set_text(Image& image, std::string_view text) const {
  if (text.size() + 1 < 2 * image.voxels()) fail("has fewer numbers than its header says voxels");
  std::vector<double> values = numbers(std::string(text), "data");
  image.number = Number::float64;
  image.swapped = false;
  set_data(image, {reinterpret_cast<const char*>(values.data()), 8 * values.size()});
}

Image ImageReader::read_nifti() {
  std::string file = load(path_);
  const bool packed = file.size() > 2 && file[0] == '\x1f' && file[1] == '\x8b';
  constexpr std::size_t header_bytes = 540;
  std::string header = packed ? unpacked(file, header_bytes, false) : file.substr(0, header_bytes);
  if (header.size() < 348) fail("is no NIfTI image: its header of 348 bytes is cut");
  Image image;
  const auto first = number_at<std::int32_t>(header.data(), false);
  image.swapped = first != 348 && first != 540;
  const auto length = number_at<std::int32_t>(header.data(), image.swapped);
  const bool second = length == 540;
  if ((length != 348 && !second) || (second && header.size() < 540))
    fail("is no NIfTI image: its header has another size");
  const auto whole = [&](std::size_t at) { return number_at<std::int16_t>(header.data() + at, image.swapped); };
  const auto real = [&](std::size_t one, std::size_t two) {
    return second ? number_at<double>(header.data() + two, image.swapped)
                  : double{number_at<float>(header.data() + one, image.swapped)};
  };
  const std::string magic = header.substr(second ? 4 : 344, 3);
  const bool single = magic == "n+1" || magic == "n+2";
  if (!single && magic != "ni1" && magic != "ni2")
    fail("is no NIfTI image: its header lacks the mark n+1, ni1, n+2 or ni2" +
         std::string(path_.ends_with(".hdr") ? "; where it is Analyze 7.5, convert it to NIfTI" : ""));
  const auto dim = [&](std::size_t i) {
    return second ? number_at<std::int64_t>(header.data() + 16 + 8 * i, image.swapped)
                  : std::int64_t{whole(40 + 2 * i)};
  };
  std::vector<std::size_t> counts;
  if (dim(0) < 1 || dim(0) > 7) fail("its header says " + std::to_string(dim(0)) + " dimensions; needed: three");
  for (std::size_t i = 1; i <= static_cast<std::size_t>(dim(0)); ++i) {
    if (dim(i) < 1 || dim(i) > kMostVoxels)
      fail("its dimension " + std::to_string(i) + " is " + std::to_string(dim(i)));
    counts.push_back(dim(i));
  }
  set_size(image, counts);
  const int code = whole(second ? 12 : 70);
  const auto* row =
      std::find_if(std::begin(kNifti), std::end(kNifti), [&](const auto& own) { return own.code == code; });
  if (row == std::end(kNifti))
    fail("has NIfTI's data type " + std::to_string(code) + (code == 128 || code == 2304 ? " (colours)" : "") +
         "; those that are read: 2, 4, 8, 256, 512, 768, 1024, 1280 (integers), 16, 64 (real numbers)");
  image.number = row->number;
  if (const double slope = real(112, 176); slope != 0 && std::isfinite(slope)) {
    image.slope = slope;
    image.intercept = real(116, 184);
  }
  const int units =
      (second ? number_at<std::int32_t>(header.data() + 500, image.swapped) : static_cast<unsigned char>(header[123])) &
      7;
  image.unit = units == 1 ? 1 : units == 2 ? 1e-3 : units == 3 ? 1e-6 : 0;
  image.space = "RAS";
  const int qform = second ? number_at<std::int32_t>(header.data() + 344, image.swapped) : whole(252);
  const int sform = second ? number_at<std::int32_t>(header.data() + 348, image.swapped) : whole(254);
  const auto pixdim = [&](std::size_t i) { return real(76 + 4 * i, 104 + 8 * i); };
  const auto of_qform = [&] {  // [nifti1.h, method 2]
    const double b = real(256, 352), c = real(260, 360), d = real(264, 368);
    const double a = std::sqrt(std::max(0., 1 - b * b - c * c - d * d));
    const double flip = pixdim(0) < 0 ? -1 : 1;
    Matrix3 turn;
    turn << a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c), 2 * (b * c + a * d),
        a * a + c * c - b * b - d * d, 2 * (c * d - a * b), 2 * (b * d - a * c), 2 * (c * d + a * b),
        a * a + d * d - c * c - b * b;
    return Matrix3(turn * Vector3(pixdim(1), pixdim(2), flip * pixdim(3)).asDiagonal());
  };
  const Vector3 qform_origin(real(268, 376), real(272, 384), real(276, 392));
  if (sform > 0) {
    for (std::size_t r = 0; r < 3; ++r) {
      const auto in_row = [&](std::size_t c) { return real(280 + 16 * r + 4 * c, 400 + 32 * r + 8 * c); };
      const auto k = static_cast<Eigen::Index>(r);
      image.steps.row(k) << in_row(0), in_row(1), in_row(2);
      image.origin[k] = in_row(3);
    }
    const Vector3 own = image.steps.colwise().norm(), stated = Vector3(pixdim(1), pixdim(2), pixdim(3)).cwiseAbs();
    const auto sides = [](const Vector3& of) {
      return number(of[0], 4) + " x " + number(of[1], 4) + " x " + number(of[2], 4);
    };
    const bool sized = (stated.array() > 0).all() && (own.array() > 0).all();
    if (sized && ((own - stated).array().abs() > 0.01 * stated.array()).any())
      image.contradiction = "its 'sform' makes voxels of " + sides(own) + ", and its 'pixdim' of " + sides(stated) +
                            "; the 'sform' counts";
    else if (sized && qform > 0 &&
             ((image.steps - of_qform()).colwise().norm().array() > 0.02 * own.transpose().array()).any())
      image.contradiction = "its 'sform' turns or mirrors the axes otherwise than its 'qform'; the 'sform' counts";
    else if (const double shift = (image.origin - qform_origin).norm();
             sized && qform == sform && shift > own.minCoeff() / 2)  // of other codes, another space is meant
      image.contradiction =
          "its 'sform' lies " + number(shift, 3) + " from where its 'qform' has the first voxel; the 'sform' counts";
  } else if (qform > 0) {
    image.steps = of_qform();
    image.origin = qform_origin;
  } else {
    image.steps = Vector3(pixdim(1), pixdim(2), pixdim(3)).asDiagonal();
    image.space.clear();
  }
  const double offset =
      second ? static_cast<double>(number_at<std::int64_t>(header.data() + 168, image.swapped)) : real(108, 0);
  if (!(offset >= 0) || offset > 1e9) fail("its header says that data begin at byte " + number(offset));
  const std::size_t begin = single ? std::max(static_cast<std::size_t>(offset), static_cast<std::size_t>(length))
                                   : static_cast<std::size_t>(offset);
  check(image);
  std::string own = std::move(file);
  bool own_packed = packed;
  if (!single) {
    const std::size_t ending = path_.size() - (path_.ends_with(".gz") ? 7 : 4);
    own = load(path_.substr(0, ending) + ".img" + path_.substr(ending + 4));
    own_packed = own.size() > 2 && own[0] == '\x1f' && own[1] == '\x8b';
  }
  if (own_packed) own = unpacked(own, begin + data_bytes(image));
  set_data(image, std::string_view(own).substr(std::min(begin, own.size())));
  return image;
}

/// A line of a header in a message; of another file's bytes none are shown.
std::string quoted(const std::string& line) {
  const bool text = std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; });
  return text ? "'" + line.substr(0, 60) + "'" : "bytes that are no text";
}

/// "a: b" and "a:=b", "a = b": without blanks around.
std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
  return first == std::string_view::npos ? "" : std::string(text.substr(first, last - first + 1));
}

double ImageReader::unit_of(const std::string& text, const std::string& key) const {
  std::vector<std::string> names;  // in quotes
  for (std::size_t at = text.find('"'); at != std::string::npos && names.size() < 3;) {
    const std::size_t end = std::min(text.find('"', at + 1), text.size());
    names.push_back(trimmed(text.substr(at + 1, end - at - 1)));
    at = text.find('"', end + 1);
  }
  if (names.empty() || names[0].empty()) return 0;
  for (const std::string& name : names)
    if (name != names[0]) fail("its '" + key + "' are " + text + "; needed: the same along all axes");
  try {
    return parse_quantity("1 " + names[0], dimension::length).value;
  } catch (const InputError&) {
    return 0;  // "pixels", "???"
  }
}

std::string small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// The directions of x, y and z, both ways round: RAS is NIfTI's space.
constexpr const char* kDirections[3][2] = {{"right", "left"}, {"anterior", "posterior"}, {"superior", "inferior"}};

/// "LPS" for "left-posterior-superior" and "lps"; another text stays as it is.
std::string space_letters(const std::string& space) {
  std::string words, letters;
  for (int choice = 0; choice < 8; ++choice) {
    words.clear(), letters.clear();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string word = kDirections[axis][choice >> axis & 1];
      words += (axis ? "-" : "") + word;
      letters += static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
    }
    if (small_letters(space) == words || small_letters(space) == small_letters(letters)) return letters;
  }
  return space;
}

/// Whether an axis of a space goes against that of RAS.
bool against_ras(const std::string& space, std::size_t axis) {
  return space.size() == 3 && space == space_letters(space) &&
         std::tolower(static_cast<unsigned char>(space[axis])) == kDirections[axis][1][0];
}

Image ImageReader::read_nrrd() {
  std::string file = load(path_);
  if (file.compare(0, 4, "NRRD") != 0) fail("is no NRRD image: it does not begin with NRRD");
  std::map<std::string, std::string> fields, pairs;
  std::size_t at = file.find('\n');
  std::size_t data_at = file.size();
  while (at != std::string::npos && at + 1 < file.size()) {
    const std::size_t begin = at + 1, end = std::min(file.find('\n', begin), file.size());
    const std::string line = trimmed(std::string_view(file).substr(begin, end - begin));
    at = end;
    if (line.empty()) {
      data_at = std::min(end + 1, file.size());
      break;
    }
    if (line[0] == '#') continue;
    const std::size_t colon = line.find(':');
    if (fields["data file"].starts_with("LIST") || fields["datafile"].starts_with("LIST")) break;  // names of files
    if (colon == std::string::npos) fail("its header has a line without a colon: " + quoted(line));
    const std::string key = trimmed(line.substr(0, colon));
    if (line.compare(colon, 2, ":=") == 0)
      pairs[key] = trimmed(line.substr(colon + 2));
    else
      fields[small_letters(key)] = trimmed(line.substr(colon + 1));
  }
  const auto needed = [&](const std::string& key) -> const std::string& {
    const auto found = fields.find(key);
    if (found == fields.end()) fail("its header lacks '" + key + "'");
    return found->second;
  };
  const auto given = [&](const std::string& key) {
    const auto found = fields.find(key);
    return found == fields.end() ? std::string() : found->second;
  };
  Image image;
  image.number = number_named(kNrrd, small_letters(needed("type")));
  std::vector<std::size_t> counts = sizes(needed("sizes"), "sizes");
  if (std::to_string(counts.size()) != needed("dimension"))
    fail("its 'dimension' is " + needed("dimension") + ", and its 'sizes' are " + std::to_string(counts.size()));
  // An axis of one value, of a list or of times, may come first.
  if (counts.size() == 4 && counts[0] == 1 && given("space directions").starts_with("none")) {
    counts.erase(counts.begin());
    fields["space directions"].erase(0, 4);
  }
  set_size(image, counts);
  const std::string encoding = small_letters(needed("encoding"));
  const bool ascii = encoding == "ascii" || encoding == "text" || encoding == "txt";
  if (bytes_of(image.number) > 1 && !ascii) {
    const std::string endian = small_letters(needed("endian"));
    if (endian != "little" && endian != "big") fail("its 'endian' is '" + endian + "'; needed: little or big");
    image.swapped = (endian == "big") != (std::endian::native == std::endian::big);
  }
  if (const std::string text = given("space directions"); !text.empty()) {
    const std::vector<double> all = numbers(text.substr(0, text.find("none")), "space directions");
    if (all.size() != 9)
      fail("its 'space directions' are '" + text + "'; needed: three vectors of three finite numbers");
    image.steps = Eigen::Map<const Matrix3>(all.data());
    const bool in_space = !given("space units").empty();
    image.unit = in_space ? unit_of(given("space units"), "space units") : unit_of(given("units"), "units");
  } else if (const std::string spacings = given("spacings"); !spacings.empty()) {
    const std::vector<double> all = numbers(spacings.substr(0, small_letters(spacings).find("nan")), "spacings");
    if (!all.empty() && all.size() < 3) fail("its 'spacings' are '" + spacings + "'; needed: three finite numbers");
    image.has_steps = !all.empty();  // "nan": not known
    if (image.has_steps) image.steps = Vector3(all[0], all[1], all[2]).asDiagonal();
    image.unit = unit_of(given("units"), "units");
  } else {
    image.has_steps = false;
  }
  if (const std::string text = given("space origin"); !text.empty()) {
    const std::vector<double> all = numbers(text, "space origin");
    if (all.size() != 3) fail("its 'space origin' is '" + text + "'; needed: three numbers");
    image.origin = {all[0], all[1], all[2]};
  } else if (given("space directions").empty()) {
    // The outer sides of the first and last voxels, or their middles where samples are on nodes. [nrrdOriginCalculate]
    const auto limits = [&](const std::string& key, const std::string& other) {
      const std::string limit = given(key) + given(other);
      std::vector<double> all = numbers(limit.substr(0, small_letters(limit).find("nan")), key);
      if (!all.empty() && all.size() < 3) fail("its '" + key + "' are '" + limit + "'; needed: three finite numbers");
      return all;
    };
    const std::vector<double> mins = limits("axis mins", "axismins"), maxs = limits("axis maxs", "axismaxs");
    if (!mins.empty() && !image.has_steps && maxs.empty())
      fail(
          "has 'axis mins' without 'axis maxs' or 'spacings'; needed: both, or 'space origin' with 'space directions'");
    std::string centers = given("centers") + given("centerings");
    for (int axis = 0; axis < 3 && !mins.empty(); ++axis) {
      const bool node = centers.starts_with("node");
      centers = trimmed(centers.substr(std::min(centers.find(' '), centers.size())));
      const int steps = image.size[axis] - (node ? 1 : 0);
      if (!image.has_steps) image.steps(axis, axis) = (maxs[axis] - mins[axis]) / std::max(1, steps);
      image.origin[axis] = mins[axis] + (node ? 0 : image.steps(axis, axis) / 2);
    }
    image.has_steps |= !mins.empty();
  }
  image.space = space_letters(given("space"));
  for (const auto& [key, value] : pairs)
    if (const std::size_t end = key.find("_LabelValue"); key.starts_with("Segment") && end != key.npos)
      if (const auto name = pairs.find(key.substr(0, end) + "_Name"); name != pairs.end() && !name->second.empty())
        image.names.emplace(count(value, key), name->second);
  check(image);
  std::string other;
  std::string_view data = std::string_view(file).substr(data_at);
  std::string name = given("data file");
  if (name.empty()) name = given("datafile");
  if (name.compare(0, 4, "LIST") == 0 || name.find('%') != std::string::npos) fail(kSeveralFiles);
  if (!name.empty()) {
    other = load(path_next_to(name));
    data = other;
  }
  for (const char* key : {"line skip", "lineskip"})
    if (const std::string text = given(key); !text.empty())
      for (double lines = count(text, key); lines > 0 && !data.empty(); --lines)
        data.remove_prefix(std::min(data.size(), std::min(data.find('\n'), data.size() - 1) + 1));
  double skip = 0;
  for (const char* key : {"byte skip", "byteskip"})
    if (const std::string text = given(key); !text.empty()) skip = count(text, key);
  std::string plain;
  if (encoding == "gzip" || encoding == "gz") {
    plain = unpacked(data, data_bytes(image) + static_cast<std::size_t>(std::clamp(skip, 0., 1e9)));
    data = plain;
  } else if (ascii) {
    set_text(image, data);
    return image;
  } else if (encoding != "raw") {
    fail("its 'encoding' is '" + encoding + "'; needed: raw, gzip or ascii");
  }
  if (skip == -1) skip = static_cast<double>(data.size()) - static_cast<double>(data_bytes(image));
  data.remove_prefix(std::min(data.size(), static_cast<std::size_t>(std::clamp(skip, 0., 1e12))));
  set_data(image, data);
  return image;
}

Image ImageReader::read_meta() {
  const std::string file = load(path_);
  std::map<std::string, std::string> fields;
  std::size_t at = 0;
  while (at < file.size() && !fields.contains("ElementDataFile")) {
    const std::size_t end = std::min(file.find('\n', at), file.size());
    const std::string line = trimmed(std::string_view(file).substr(at, end - at));
    at = std::min(end + 1, file.size());
    const std::size_t equals = line.find('=');
    if (line.empty()) continue;
    if (equals == std::string::npos) fail("is no MetaImage: its header has a line without '=': " + quoted(line));
    fields[trimmed(line.substr(0, equals))] = trimmed(line.substr(equals + 1));
  }
  const auto given = [&](std::initializer_list<const char*> keys) {
    for (const char* key : keys)
      if (const auto found = fields.find(key); found != fields.end()) return found->second;
    return std::string();
  };
  const auto needed = [&](const char* key) {
    const std::string text = given({key});
    if (text.empty()) fail("its header lacks '" + std::string(key) + "'");
    return text;
  };
  const auto flag = [&](std::initializer_list<const char*> keys) {
    const std::string text = given(keys);
    return !text.empty() && (text[0] == 'T' || text[0] == 't' || text[0] == '1');
  };
  Image image;
  set_size(image, sizes(needed("DimSize"), "DimSize"));
  if (const std::string text = given({"ElementNumberOfChannels"}); !text.empty() && text != "1")
    fail("has " + text + " numbers a voxel; needed: one");
  image.number = number_named(kMeta, needed("ElementType"));
  image.swapped = flag({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}) != (std::endian::native == std::endian::big);
  const auto three = [&](const std::string& text, const char* key) {
    const std::vector<double> all = numbers(text, key);
    if (all.size() < 3) fail("its '" + std::string(key) + "' is '" + text + "'; needed: three numbers");
    return Vector3(all[0], all[1], all[2]);
  };
  Vector3 spacing = Vector3::Ones();
  const std::string spacings = given({"ElementSpacing", "ElementSize"});
  image.has_steps = !spacings.empty();
  if (image.has_steps) spacing = three(spacings, "ElementSpacing");
  if (const std::string text = given({"TransformMatrix", "Orientation", "Rotation"}); !text.empty()) {
    const std::vector<double> all = numbers(text, "TransformMatrix");
    const auto axes = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(all.size()))));
    if (axes < 3 || axes * axes != static_cast<Eigen::Index>(all.size()))
      fail("its 'TransformMatrix' has " + std::to_string(all.size()) + " numbers; needed: nine");
    // An axis after the other; further ones have one value, as set_size has seen.
    image.steps = Eigen::Map<const Eigen::MatrixXd>(all.data(), axes, axes).topLeftCorner<3, 3>();
  }
  image.steps = (image.steps * spacing.asDiagonal()).eval();
  if (const std::string text = given({"Offset", "Position", "Origin"}); !text.empty())
    image.origin = three(text, "Offset");
  image.space = "LPS";
  check(image);
  const std::string name = needed("ElementDataFile");
  if (name == "LIST" || name.find('%') != std::string::npos) fail(kSeveralFiles);
  std::string other;
  std::string_view data = std::string_view(file).substr(at);
  if (name != "LOCAL" && name != "local") {
    other = load(path_next_to(name));
    data = other;
  }
  const double skip = given({"HeaderSize"}).empty() ? 0 : count(given({"HeaderSize"}), "HeaderSize");
  if (flag({"CompressedData"})) {
    other = unpacked(data, data_bytes(image));
    data = other;
  } else if (!given({"BinaryData"}).empty() && !flag({"BinaryData"})) {
    set_text(image, data);
    return image;
  } else if (skip == -1 && data.size() > data_bytes(image)) {
    data.remove_prefix(data.size() - data_bytes(image));
  } else if (skip > 0) {
    data.remove_prefix(static_cast<std::size_t>(std::min(static_cast<double>(data.size()), skip)));
  }
  set_data(image, data);
  return image;
}

Image ImageReader::read_numpy() {
  const std::string file = load(path_);
  if (file.size() < 12 || file.compare(0, 6, "\x93NUMPY") != 0)
    fail("is no array of NumPy: it does not begin with its mark");
  const bool first = file[6] == 1;
  const std::size_t begin = first ? 10 : 12;
  const std::size_t length = first ? number_at<std::uint16_t>(file.data() + 8, std::endian::native == std::endian::big)
                                   : number_at<std::uint32_t>(file.data() + 8, std::endian::native == std::endian::big);
  if (begin + length > file.size()) fail("its header is cut");
  const std::string header = file.substr(begin, length);
  const auto after = [&](const std::string& key) {
    const std::size_t at = header.find("'" + key + "':");
    if (at == std::string::npos) fail("its header lacks '" + key + "'");
    return trimmed(header.substr(at + key.size() + 3));
  };
  const std::string descr = after("descr"), shape = after("shape");
  if (descr.size() < 5 || descr[0] != '\'') fail("has records; needed: one integer or real number a voxel");
  Image image;
  image.number = number_named(kNumpy, descr.substr(2, descr.find('\'', 1) - 2));
  image.swapped = bytes_of(image.number) > 1 && (descr[1] == '>') != (std::endian::native == std::endian::big);
  set_size(image, sizes(shape.substr(0, shape.find(')') + 1), "shape"));
  if (after("fortran_order").compare(0, 4, "True") != 0) {
    const std::size_t ny = image.size[1], nz = image.size[2];
    image.strides = {ny * nz, nz, 1};
  }
  image.has_steps = false;
  check(image);
  set_data(image, std::string_view(file).substr(begin + length));
  return image;
}

struct ImageFormat {
  const char* ending;
  Image (ImageReader::*read)();
};
constexpr ImageFormat kFormats[] = {
    {".nii", &ImageReader::read_nifti},    {".nii.gz", &ImageReader::read_nifti}, {".hdr", &ImageReader::read_nifti},
    {".hdr.gz", &ImageReader::read_nifti}, {".nrrd", &ImageReader::read_nrrd},    {".nhdr", &ImageReader::read_nrrd},
    {".mhd", &ImageReader::read_meta},     {".mha", &ImageReader::read_meta},     {".npy", &ImageReader::read_numpy}};

}  // namespace

const char* image_endings() { return ".nii, .nii.gz, .hdr (with .img), .nrrd, .nhdr, .mhd, .mha, .npy"; }

std::size_t ImageGrid::voxels() const { return std::size_t{1} * size[0] * size[1] * size[2]; }

double Image::at(int x, int y, int z) const {
  const char* place = data.data() + bytes_of(number) * (x * strides[0] + y * strides[1] + z * strides[2]);
  const auto value = [&]() -> double {
    switch (number) {
      case Number::int8:
        return number_at<std::int8_t>(place, false);
      case Number::uint8:
        return number_at<std::uint8_t>(place, false);
      case Number::int16:
        return number_at<std::int16_t>(place, swapped);
      case Number::uint16:
        return number_at<std::uint16_t>(place, swapped);
      case Number::int32:
        return number_at<std::int32_t>(place, swapped);
      case Number::uint32:
        return number_at<std::uint32_t>(place, swapped);
      case Number::int64:
        return static_cast<double>(number_at<std::int64_t>(place, swapped));
      case Number::uint64:
        return static_cast<double>(number_at<std::uint64_t>(place, swapped));
      case Number::float32:
        return double{number_at<float>(place, swapped)};
      case Number::float64:
        return number_at<double>(place, swapped);
    }
    return 0;
  };
  const double own = value();
  if (slope == 1 && intercept == 0) return own;
  // Slope and intercept are rounded to single precision: -5 · 0.1 + 0.5 is 0, and not -7e-9.
  constexpr double rounding = std::numeric_limits<float>::epsilon();
  const double scaled = slope * own + intercept, whole = std::round(scaled);
  return std::abs(scaled - whole) <= rounding * (std::abs(slope * own) + std::abs(intercept)) ? whole : scaled;
}

namespace {

std::string gzipped(std::string_view bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw InputError("zlib cannot start");
  std::string packed;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  for (int code = Z_OK; code == Z_OK;) {
    stream.avail_in = static_cast<uInt>(std::min<std::size_t>(
        static_cast<std::size_t>(bytes.data() + bytes.size() - reinterpret_cast<const char*>(stream.next_in)),
        1 << 30));
    const bool last = reinterpret_cast<const char*>(stream.next_in) + stream.avail_in == bytes.data() + bytes.size();
    const std::size_t before = packed.size();
    packed.resize(before + (1 << 20));
    stream.next_out = reinterpret_cast<Bytef*>(packed.data() + before);
    stream.avail_out = 1 << 20;
    code = deflate(&stream, last ? Z_FINISH : Z_NO_FLUSH);
    packed.resize(packed.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  return packed;
}

/// Little-endian, as all machines that Elastin is built for.
template <class T>
void put(std::string& header, std::size_t at, T value) {
  std::memcpy(header.data() + at, &value, sizeof value);
}

/// `components` numbers a voxel, one component after the other.
std::string nifti_text(const ImageGrid& grid, ImageContent content, const std::string& data) {
  std::string header(352, '\0');
  put(header, 0, std::int32_t{348});
  const bool vectors = content == ImageContent::displacements;
  const auto size = [&](int axis) { return static_cast<std::int16_t>(grid.size[axis]); };
  const std::int16_t dim[] = {std::int16_t(vectors ? 5 : 3), size(0), size(1), size(2), 1,
                              std::int16_t(vectors ? 3 : 1), 1,       1};
  for (std::size_t i = 0; i < 8; ++i) put(header, 40 + 2 * i, dim[i]);
  if (vectors) put(header, 68, std::int16_t{1006});  // NIFTI_INTENT_DISPVECT
  put(header, 70, std::int16_t(content == ImageContent::labels ? 8 : 16));
  put(header, 72, std::int16_t{32});
  put(header, 76, 1.f);
  for (int axis = 0; axis < 3; ++axis) put(header, 80 + 4 * axis, static_cast<float>(grid.steps.col(axis).norm()));
  put(header, 108, 352.f);
  put(header, 112, 1.f);
  header[123] = static_cast<char>(grid.unit == 1 ? 1 : grid.unit == 1e-3 ? 2 : grid.unit == 1e-6 ? 3 : 0);
  put(header, 254, std::int16_t{1});
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      const double value = column < 3 ? grid.steps(row, column) : grid.origin[row];
      put(header, 280 + 16 * row + 4 * column, static_cast<float>(against_ras(grid.space, row) ? -value : value));
    }
  header.replace(344, 3, "n+1");
  return header + data;
}

/// As NRRD names it: "left-posterior-superior".
std::string space_name(const std::string& space) {
  if (space.size() != 3 || space != space_letters(space)) return space;
  std::string name;
  for (std::size_t axis = 0; axis < 3; ++axis)
    name += std::string(axis ? "-" : "") + kDirections[axis][against_ras(space, axis) ? 1 : 0];
  return name;
}

std::string nrrd_text(const ImageGrid& grid, ImageContent content, const std::string& data) {
  const bool vectors = content == ImageContent::displacements;
  const auto of = [](const Vector3& at) {
    return "(" + number(at.x(), 17) + "," + number(at.y(), 17) + "," + number(at.z(), 17) + ")";
  };
  std::string text = "NRRD0004\ntype: ";
  text += content == ImageContent::labels ? "int32" : "float";
  text += vectors ? "\ndimension: 4\n" : "\ndimension: 3\n";
  text += grid.space.empty() ? "space dimension: 3\n" : "space: " + space_name(grid.space) + "\n";
  text += vectors ? "sizes: 3" : "sizes:";
  for (const int size : grid.size) text += " " + std::to_string(size);
  text += vectors ? "\nkinds: vector domain domain domain\nspace directions: none" : "\nspace directions:";
  for (int axis = 0; axis < 3; ++axis) text += " " + of(grid.steps.col(axis));
  return text + "\nspace origin: " + of(grid.origin) + "\nendian: little\nencoding: gzip\n\n" + gzipped(data);
}

}  // namespace

std::string image_text(const std::string& path, const ImageGrid& grid, ImageContent content,
                       const std::vector<float>& values) {
  const std::string name = small_letters(path);
  const bool nrrd = name.ends_with(".nrrd"), packed = name.ends_with(".nii.gz");
  if (!nrrd && !packed && !name.ends_with(".nii"))
    throw InputError(path + ": is no image that is written: .nii, .nii.gz, .nrrd");
  const std::size_t components = content == ImageContent::displacements ? 3 : 1, voxels = grid.voxels();
  if (!nrrd && *std::max_element(grid.size.begin(), grid.size.end()) > 32767)
    throw InputError(path + ": has more than 32767 voxels along an axis, which .nii does not count; write .nrrd");
  std::string data(4 * values.size(), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (content == ImageContent::labels)
      put(data, 4 * i, static_cast<std::int32_t>(values[i]));
    else if (nrrd)
      put(data, 4 * i, values[i]);
    else  // one component after the other
      put(data, 4 * (i / components + i % components * voxels),
          components == 3 && against_ras(grid.space, i % 3) ? -values[i] : values[i]);
  }
  if (nrrd) return nrrd_text(grid, content, data);
  const std::string text = nifti_text(grid, content, data);
  return packed ? gzipped(text) : text;
}

Image load_image(const std::string& path, const std::function<void(const ImageGrid&)>& check) {
  const std::string name = small_letters(path);
  for (const ImageFormat& format : kFormats)
    if (name.ends_with(format.ending)) {
      ImageReader reader(path, check);
      return (reader.*format.read)();
    }
  throw InputError(path + ": is no image that is read: " + image_endings() +
                   (name.ends_with(".dcm") || name.ends_with(".ima") ||
                            name.find('.', name.find_last_of('/') + 1) == std::string::npos
                        ? "; convert slices of DICOM: dcm2niix -z y FOLDER"
                        : "; convert it, with 3D Slicer or ITK-SNAP for example"));
}

}  // namespace elastin::mesh
