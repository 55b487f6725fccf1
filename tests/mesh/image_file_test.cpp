#include "mesh/image_file.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "elastin/core/base/error.h"

using namespace elastin;
using namespace elastin::mesh;

namespace {

std::filesystem::path folder() {
  const auto path = std::filesystem::temp_directory_path() / "elastin_images";
  std::filesystem::create_directories(path);
  return path;
}

std::string write(const std::string& name, const std::string& bytes) {
  const std::string path = (folder() / name).string();
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string packed(const std::string& bytes) {
  const std::string path = (folder() / "packed.gz").string();
  gzFile file = gzopen(path.c_str(), "wb");
  gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(file);
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
std::string bytes_of(T value, bool swapped = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// x + 10 y + 100 z of 3 × 4 × 2 voxels, x fastest.
template <class T>
std::string numbers(bool swapped = false) {
  std::string bytes;
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 3; ++x) bytes += bytes_of(static_cast<T>(x + 10 * y + 100 * z), swapped);
  return bytes;
}

struct Nifti {
  std::string header = std::string(352, '\0');
  bool swapped = false;
  template <class T>
  void put(std::size_t at, T value) {
    header.replace(at, sizeof value, bytes_of(value, swapped));
  }
  explicit Nifti(std::int16_t type, bool swapped_bytes = false) : swapped(swapped_bytes) {
    put(0, std::int32_t{348});
    const std::int16_t dim[] = {3, 3, 4, 2, 1, 1, 1, 1};
    const float pixdim[] = {1, 1, 2, 3, 0, 0, 0, 0};
    for (std::size_t i = 0; i < 8; ++i) put(40 + 2 * i, dim[i]), put(76 + 4 * i, pixdim[i]);
    put(70, type);
    put(108, 352.F);
    header[123] = 2;
    header.replace(344, 4, std::string("n+1\0", 4));
  }
};

void check_values(const Image& image) {
  REQUIRE(image.size == std::array<int, 3>{3, 4, 2});
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 3; ++x) CHECK(image.at(x, y, z) == x + 10 * y + 100 * z);
}

std::string message_of(const std::string& path) {
  try {
    load_image(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("image: the same voxels from every format", "[image]") {
  const std::string raw = numbers<std::int16_t>(), turned = numbers<std::int16_t>(true);
  for (const bool swapped : {false, true}) {
    Nifti nifti(4, swapped);
    nifti.put(254, std::int16_t{1});
    const float rows[] = {0, -2, 0, 5, 1, 0, 0, 6, 0, 0, 3, 7};  // x goes along y, and y against x
    for (std::size_t i = 0; i < 12; ++i) nifti.put(280 + 4 * i, rows[i]);
    for (const bool gzip : {false, true}) {
      const std::string bytes = nifti.header + (swapped ? turned : raw);
      const Image image = load_image(write(gzip ? "a.nii.gz" : "a.nii", gzip ? packed(bytes) : bytes));
      check_values(image);
      CHECK(image.space == "RAS");
      CHECK(image.unit == 1e-3);
      CHECK(image.origin == Vector3(5, 6, 7));
      CHECK(image.steps.col(0) == Vector3(0, 1, 0));
      CHECK(image.steps.col(1) == Vector3(-2, 0, 0));
      CHECK(image.steps.col(2) == Vector3(0, 0, 3));
    }
  }
  SECTION("what contradicts the sform is stated") {
    Nifti nifti(4);
    const auto stated = [&] { return load_image(write("s.nii", nifti.header + raw)).contradiction; };
    nifti.put(254, std::int16_t{1});
    const float rows[] = {1, 0, 0, 5, 0, 2, 0, 6, 0, 0, 3, 7};
    for (std::size_t i = 0; i < 12; ++i) nifti.put(280 + 4 * i, rows[i]);
    CHECK(stated() == "");
    nifti.put(252, std::int16_t{2});  // another space, whose origin is its own
    CHECK(stated() == "");
    nifti.put(252, std::int16_t{1});
    CHECK(stated() == "its 'sform' lies 10.5 from where its 'qform' has the first voxel; the 'sform' counts");
    for (const std::size_t i : {0U, 1U, 2U}) nifti.put(268 + 4 * i, 5.F + static_cast<float>(i));
    CHECK(stated() == "");
    nifti.put(76, -1.F);  // the qform reverses the third axis
    CHECK(stated() == "its 'sform' turns or mirrors the axes otherwise than its 'qform'; the 'sform' counts");
    nifti.put(80, 0.5F);
    CHECK(stated() == "its 'sform' makes voxels of 1 x 2 x 3, and its 'pixdim' of 0.5 x 2 x 3; the 'sform' counts");
  }
  SECTION("quaternions turn by 90 degrees about z") {
    Nifti nifti(4);
    nifti.put(252, std::int16_t{1});
    nifti.put(264, static_cast<float>(std::sqrt(0.5)));
    nifti.put(76, -1.F);  // the third axis is reversed
    const Image image = load_image(write("q.nii", nifti.header + raw));
    CHECK((image.steps.col(0) - Vector3(0, 1, 0)).norm() < 1e-6);
    CHECK((image.steps.col(1) - Vector3(-2, 0, 0)).norm() < 1e-6);
    CHECK((image.steps.col(2) - Vector3(0, 0, -3)).norm() < 1e-6);
  }
  const std::string nrrd =
      "NRRD0004\n# comment\ntype: short\ndimension: 3\nsizes: 3 4 2\nspace: left-posterior-superior\n"
      "space directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (5,6,7)\n";
  write("b.raw", raw);
  std::string text;
  for (int i = 0; i < 24; ++i) text += std::to_string(i % 3 + 10 * (i / 3 % 4) + 100 * (i / 12)) + " ";
  for (const auto& [name, bytes] :
       {std::pair<std::string, std::string>{"b1.nrrd", nrrd + "endian: little\nencoding: raw\n\n" + raw},
        {"b2.nrrd", nrrd + "endian: big\nencoding: raw\n\n" + turned},
        {"b3.nrrd", nrrd + "endian: little\nencoding: gzip\n\n" + packed(raw)},
        {"b4.nrrd", nrrd + "encoding: ascii\n\n" + text},
        {"b5.nhdr", nrrd + "endian: little\nencoding: raw\ndata file: b.raw\n"}}) {
    INFO(name);
    const Image image = load_image(write(name, bytes));
    check_values(image);
    CHECK(image.space == "LPS");
    CHECK(image.origin == Vector3(5, 6, 7));
    CHECK(image.steps.col(1) == Vector3(0, 2, 0));
  }
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 3 4 2\nElementType = MET_SHORT\nElementSpacing = 1 2 3\nOffset = 5 6 "
      "7\n"
      "TransformMatrix = 0 1 0 -1 0 0 0 0 1\n";
  for (const auto& [name, bytes] :
       {std::pair<std::string, std::string>{"c1.mha", meta + "BinaryData = True\nElementDataFile = LOCAL\n" + raw},
        {"c2.mhd", meta + "ElementDataFile = b.raw\n"},
        {"c3.mha", meta + "BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\n" + turned},
        {"c4.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" + packed(raw)}}) {
    INFO(name);
    const Image image = load_image(write(name, bytes));
    check_values(image);
    CHECK(image.steps.col(0) == Vector3(0, 1, 0));
    CHECK(image.steps.col(1) == Vector3(-2, 0, 0));
  }
  std::string header = "{'descr': '<i2', 'fortran_order': True, 'shape': (3, 4, 2), }";
  header.resize(117, ' ');
  const std::string npy =
      std::string("\x93NUMPY\x01\x00", 8) + bytes_of(static_cast<std::uint16_t>(118)) + header + "\n";
  const Image image = load_image(write("d.npy", npy + raw));
  check_values(image);
  CHECK(!image.has_steps);
}

TEST_CASE("image: numbers of every type, and scaled ones", "[image]") {
  const auto check = [](std::int16_t code, const std::string& bytes) {
    CAPTURE(code);
    check_values(load_image(write("t.nii", Nifti(code).header + bytes)));
  };
  check(2, numbers<std::uint8_t>());
  check(8, numbers<std::int32_t>());
  check(16, numbers<float>());
  check(64, numbers<double>());
  check(512, numbers<std::uint16_t>());
  check(768, numbers<std::uint32_t>());
  check(1024, numbers<std::int64_t>());
  check(1280, numbers<std::uint64_t>());
  Nifti scaled(4);
  scaled.put(112, 2.F);
  scaled.put(116, -3.F);
  CHECK(load_image(write("s.nii", scaled.header + numbers<std::int16_t>())).at(1, 1, 1) == 2 * 111 - 3);
}

TEST_CASE("image: scaled values are whole numbers but for the rounding of their scale", "[image]") {
  Nifti scaled(4);
  scaled.put(112, 0.1F);
  scaled.put(116, 0.5F);
  std::string bytes;
  for (int value = -5; value < 19; ++value) bytes += bytes_of(static_cast<std::int16_t>(value == 18 ? 29995 : value));
  const Image image = load_image(write("w.nii", scaled.header + bytes));
  CHECK(image.at(0, 0, 0) == 0);
  CHECK(image.at(1, 3, 0) == 1);
  CHECK(image.at(1, 2, 1) == Approx(1.9));
  CHECK(image.at(2, 3, 1) == 3000);
}

TEST_CASE("image: every space is written back, and as RAS to NIfTI", "[image]") {
  const std::string nrrd =
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 2\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n"
      "space origin: (5,6,7)\nencoding: raw\n";
  struct Case {
    std::string space, letters, name;
    Vector3 signs;
  };
  for (const Case& own : {Case{"right-anterior-superior", "RAS", "right-anterior-superior", {1, 1, 1}},
                          {"RAS", "RAS", "right-anterior-superior", {1, 1, 1}},
                          {"left-anterior-superior", "LAS", "left-anterior-superior", {-1, 1, 1}},
                          {"LAS", "LAS", "left-anterior-superior", {-1, 1, 1}},
                          {"left-posterior-superior", "LPS", "left-posterior-superior", {-1, -1, 1}},
                          {"RPS", "RPS", "right-posterior-superior", {1, -1, 1}},
                          {"left-posterior-inferior", "LPI", "left-posterior-inferior", {-1, -1, -1}},
                          {"scanner-xyz", "scanner-xyz", "scanner-xyz", {1, 1, 1}},
                          {"", "", "", {1, 1, 1}}}) {
    INFO(own.space);
    const std::string space = own.space.empty() ? "" : "space: " + own.space + "\n";
    const Image image = load_image(write("space.nrrd", nrrd + space + "\n" + numbers<std::uint8_t>()));
    CHECK(image.space == own.letters);
    const std::vector<float> vectors(3 * 24, 1);
    const auto text = image_text("out.nii", image, ImageContent::displacements, vectors);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float vector = 0;
      std::memcpy(&vector, text.data() + 352 + 4 * 24 * axis, 4);
      CHECK(vector == own.signs[static_cast<int>(axis)]);
    }
    const std::vector<float> labels(24, 1);
    const Image nifti = load_image(write("out.nii", image_text("out.nii", image, ImageContent::labels, labels)));
    CHECK(nifti.origin == own.signs.cwiseProduct(image.origin));
    CHECK(nifti.steps == own.signs.asDiagonal() * image.steps);
    const auto written = image_text("out.nrrd", image, ImageContent::labels, labels);
    CHECK((written.find("\nspace: " + own.name + "\n") != std::string::npos) == !own.name.empty());
    CHECK(load_image(write("out.nrrd", written)).space == own.letters);
  }
}

TEST_CASE("image: what is broken or odd is named", "[image]") {
  const std::string raw = numbers<std::int16_t>();
  const auto nifti = [&](auto change) {
    Nifti own(4);
    change(own);
    return own.header + raw;
  };
  const std::string nrrd = "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 2\nspacings: 1 2 3\nendian: little\n";
  const std::string meta = "NDims = 3\nDimSize = 3 4 2\nElementType = MET_SHORT\nElementSpacing = 1 2 3\n";
  const std::string gzip = packed(nifti([](Nifti&) {}));
  const auto turned_at = [](std::string bytes, std::size_t at) {
    bytes[at] = static_cast<char>(~bytes[at]);
    return bytes;
  };
  const auto npy = [](const std::string& text) {
    return std::string("\x93NUMPY\x01\x00", 8) + bytes_of(static_cast<std::uint16_t>(text.size())) + text;
  };
  struct Case {
    std::string name, bytes, message;
  };
  for (const Case& own : {
           Case{"e1.nii", "", "header"},
           {"e2.nii", std::string(348, '\0'), "header"},
           {"e3.nii", nifti([](Nifti& n) { n.header.resize(200); }), "header"},
           {"e4.nii", nifti([](Nifti& n) { n.put(42, std::int16_t{300}); }), "bytes of data"},
           {"e5.nii", nifti([](Nifti& n) { n.put(42, std::int16_t{0}); }), "dimension 1 is 0"},
           {"e6.nii", nifti([](Nifti& n) { n.put(40, std::int16_t{4}), n.put(48, std::int16_t{2}); }), "4 dimensions"},
           {"e7.nii", nifti([](Nifti& n) { n.put(70, std::int16_t{128}); }), "colours"},
           {"e8.nii", nifti([](Nifti& n) { n.put(70, std::int16_t{32}); }), "data type 32"},
           {"e9.nii", nifti([](Nifti& n) { n.put(80, 0.F); }), "no volume"},
           {"e10.nii", nifti([](Nifti& n) { n.put(80, NAN); }), "no volume"},
           {"e11.nii", nifti([](Nifti& n) { n.put(254, std::int16_t{1}); }), "no volume"},
           {"e12.nii", nifti([](Nifti& n) {
              n.put(42, std::int16_t{1000}), n.put(44, std::int16_t{1000}), n.put(46, std::int16_t{1000});
            }),
            "bytes of data"},
           {"e13.nii", nifti([](Nifti& n) {
              n.put(42, std::int16_t{32000}), n.put(44, std::int16_t{32000}), n.put(46, std::int16_t{32000});
            }),
            "at most"},
           {"e14.nii", nifti([](Nifti& n) { n.put(108, -5.F); }), "begin at byte"},
           {"e15.nii", nifti([](Nifti& n) { n.header.replace(344, 3, "abc"); }), "mark"},
           {"e16.nii", nifti([](Nifti& n) { n.put(40, std::int16_t{9}); }), "9 dimensions"},
           {"e17.nii.gz", gzip.substr(0, gzip.size() / 2), "packed data"},
           {"e18.nii.gz", gzip.substr(0, 12), "packed data"},
           {"e19.hdr", nifti([](Nifti& n) { n.header.replace(344, 3, "ni1"); }), "cannot open"},
           {"e20.nii", nifti([](Nifti& n) { n.put(112, 1.F), n.put(116, INFINITY); }), "not finite"},
           {"e21.nii.gz", turned_at(gzip, gzip.size() - 8), "incorrect data check"},
           {"e22.nii.gz", gzip.substr(0, gzip.size() - 8), "packed data end early"},
           {"e23.nii", nifti([](Nifti&) {}) + raw, "has 96 bytes of data; its header says 3 x 4 x 2 voxels, 48 bytes"},
           {"e24.nii.gz", packed(nifti([](Nifti&) {}) + raw), "has 96 bytes of data"},
           {"f1.nrrd", "PNG", "begin with NRRD"},
           {"f2.nrrd", nrrd + "encoding: raw\n\n" + raw.substr(1), "bytes of data"},
           {"f18.nrrd", nrrd + "encoding: raw\n\n" + raw + raw, "has 96 bytes of data"},
           {"f19.nrrd", nrrd + "encoding: gzip\n\n" + packed(raw + raw), "has 96 bytes of data"},
           {"f20.nrrd", nrrd + "encoding: gzip\n\n" + turned_at(packed(raw), packed(raw).size() - 5), "data check"},
           {"f3.nrrd", nrrd + "encoding: bzip2\n\n" + raw, "bzip2"},
           {"f4.nrrd", nrrd + "\n" + raw, "'encoding'"},
           {"f5.nrrd", "NRRD0004\ntype: block\ndimension: 3\nsizes: 3 4 2\nencoding: raw\n\n" + raw, "block"},
           {"f6.nrrd", "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 3 4 2\nencoding: raw\n\n" + raw, "4 dimensions"},
           {"f7.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4\nencoding: raw\n\n" + raw, "'dimension'"},
           {"f8.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 -4 2\nencoding: raw\n\n" + raw, "'sizes'"},
           {"f9.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 2\nencoding: raw\n\n" + raw, "'endian'"},
           {"f10.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 2\nencoding: ascii\n\n1 2 3", "fewer numbers"},
           {"f11.nrrd", nrrd + "encoding: gzip\n\n" + raw, "packed data"},
           {"f12.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 2\nspace directions: (1,0,0) (2,0,0) (0,0,1)\nencoding: "
            "raw\n\n" +
                raw,
            "no volume"},
           {"f13.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 2\nspace directions: none (1,0,0) (0,1,0) "
            "(0,0,1)\nencoding: raw\n\n" +
                raw,
            "three vectors of three finite numbers"},
           {"f14.nhdr", nrrd + "encoding: raw\ndata file: LIST\na.raw\nb.raw\n", "several files"},
           {"f21.nrrd",
            "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 2\nspacings: 1 2 3\nunits: \"mm\" \"mm\" \"cm\"\nendian: "
            "little\nencoding: raw\n\n" +
                raw,
            "needed: the same along all axes"},
           {"f22.nrrd",
            "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 2\naxis mins: 1 2 3\nendian: little\nencoding: raw\n\n" +
                raw,
            "'axis mins' without 'axis maxs'"},
           {"f23.nrrd",
            "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 2\naxis mins: 1 2 3\naxis maxs: 4 5\nendian: "
            "little\nencoding: raw\n\n" +
                raw,
            "its 'axis maxs' are '4 5'; needed: three finite numbers"},
           {"f24.nrrd", "NRRD0004\n\x89PNG\n", "a line without a colon: bytes that are no text"},
           {"f15.nhdr", nrrd + "encoding: raw\ndata file: missing.raw\n", "cannot open"},
           {"f16.nrrd", nrrd + "encoding: raw\nline skip: 1e300\n\n" + raw, "bytes of data"},
           {"f17.nrrd", nrrd + "encoding: raw\nbyte skip: ()\n\n" + raw, "'byte skip'"},
           {"g1.mhd", "no header", "MetaImage: its header has a line without '=': 'no header'"},
           {"g10.mha", "\x89PNG\r\n", "bytes that are no text"},
           {"g11.mhd", meta + "ElementDataFile = LIST\na.raw\n",
            "several files; needed: one, as .nrrd and .mha have it"},
           {"g0.mha", meta + "HeaderSize = 1e300\nElementDataFile = LOCAL\n" + raw, "bytes of data"},
           {"g2.mha", meta + "ElementDataFile = LOCAL\n" + raw.substr(2), "bytes of data"},
           {"g7.mha", meta + "ElementDataFile = LOCAL\n" + raw + raw, "has 96 bytes of data"},
           {"g3.mha", meta + "ElementNumberOfChannels = 3\nElementDataFile = LOCAL\n" + raw, "3 numbers a voxel"},
           {"g4.mha", meta, "'ElementDataFile'"},
           {"g5.mha", "DimSize = 3 4 2\nElementType = MET_SHORT_ARRAY\nElementDataFile = LOCAL\n" + raw,
            "MET_SHORT_ARRAY"},
           {"g8.mha", "DimSize = 3 4 2\nElementType = MET_STRING\nElementDataFile = LOCAL\n" + raw,
            "'MET_STRING'; those that are read: MET_CHAR, MET_UCHAR"},
           {"g9.mha", meta + "TransformMatrix = 1 0 0 0 1\nElementDataFile = LOCAL\n" + raw, "has 5 numbers"},
           {"g6.mha", meta + "TransformMatrix = 1 0 0 1 0 0 0 0 1\nElementDataFile = LOCAL\n" + raw, "no volume"},
           {"h1.npy", "abc", "NumPy"},
           {"h2.npy", npy("{'descr': '<i2', 'fortran_order': False, 'shape': (3, 4, 2, 3), }") + raw, "4 dimensions"},
           {"h3.npy", npy("{'descr': '<c8', 'fortran_order': False, 'shape': (3, 4, 2), }") + raw, "c8"},
           {"h7.npy", npy("{'descr': '<f2', 'fortran_order': False, 'shape': (3, 4, 2), }") + raw,
            "'f2'; those that are read: i1, u1, i2, u2"},
           {"h4.npy", npy("{'descr': [('a', '<i2')], 'fortran_order': False, 'shape': (3, 4, 2), }") + raw, "records"},
           {"h5.npy", npy("{'descr': '<i2', 'fortran_order': False, 'shape': (1000, 1000, 1000), }") + raw,
            "bytes of data"},
           {"h6.npy", npy("{'descr': '<i2', 'fortran_order': True, 'shape': (3, 4, 2), }") + raw + raw, "has 96 bytes"},
           {"i.png", "", "is no image that is read"},
       }) {
    const std::string path = write(own.name, own.bytes), message = message_of(path);
    INFO(own.name << ": " << message);
    CHECK(message.find(own.name) != std::string::npos);
    CHECK(message.find(own.message) != std::string::npos);
  }
}

TEST_CASE("image: files may be padded, and packed in several pieces", "[image]") {
  const std::string raw = numbers<std::int16_t>(), bytes = Nifti(4).header + raw;
  check_values(load_image(write("p1.nii", bytes + std::string(16, '\0'))));
  check_values(load_image(write("p2.nii.gz", packed(bytes) + std::string(512, '\0'))));
  check_values(load_image(write("p3.nii.gz", packed(bytes.substr(0, 370)) + packed(bytes.substr(370)))));
}

TEST_CASE("image: units and origins of NRRD", "[image]") {
  const auto image_of = [](const std::string& fields) {
    return load_image(write("u.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 2\nencoding: raw\n" + fields +
                                          "\n\n" + numbers<std::uint8_t>()));
  };
  const std::string space = "space: RAS\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n", plain = "spacings: 1 2 3\n";
  CHECK(image_of(space + "space units: \"um\" \"um\" \"um\"").unit == Approx(1e-6));
  CHECK(image_of(space + "space units: \"pixel\" \"pixel\" \"pixel\"").unit == 0);
  CHECK(image_of(space).unit == 0);
  CHECK(image_of(plain + "units: \"cm\" \"cm\" \"cm\"").unit == Approx(1e-2));
  CHECK(image_of(space + "units: \"cm\" \"cm\" \"cm\"").unit == Approx(1e-2));
  CHECK(image_of("Spacings: 1 2 3\nUnits: \"m\" \"m\" \"m\"").unit == 1);  // fields in any letters
  CHECK(image_of(plain + "axis mins: 10 20 30").origin == Vector3(10.5, 21, 31.5));
  CHECK(image_of(plain + "axis mins: 10 20 30\ncenters: cell node node").origin == Vector3(10.5, 20, 30));
  for (const std::string centers : {"", "\ncenters: cell node node"}) {
    const Vector3 last = centers.empty() ? Vector3(13, 28, 36) : Vector3(13, 26, 33);
    const Image image = image_of("axis mins: 10 20 30\naxis maxs: " + std::to_string(last[0]) + " " +
                                 std::to_string(last[1]) + " " + std::to_string(last[2]) + centers);
    CHECK(image.has_steps);
    CHECK(image.steps.diagonal() == Vector3(1, 2, 3));
    CHECK(image.origin == (centers.empty() ? Vector3(10.5, 21, 31.5) : Vector3(10.5, 20, 30)));
  }
  CHECK(image_of(plain + "axis mins: nan nan nan").origin == Vector3::Zero());
  const std::string marks(24, '\xEF');  // data may begin as a byte order mark, a header then still has none
  write("mark.raw", "\xEF\xBB\xBF" + marks.substr(3));
  CHECK(load_image(write("mark.nhdr",
                         "\xEF\xBB\xBFNRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 4 2\nencoding: raw\n"
                         "data file: mark.raw\n\n"))
            .at(1, 0, 0) == 0xBB);
  CHECK(!image_of("spacings: nan nan nan").has_steps);
}

TEST_CASE("image: a fourth axis of one value counts for nothing", "[image]") {
  const std::string raw = numbers<std::uint8_t>();
  const std::string nrrd = "NRRD0004\ntype: uchar\ndimension: 4\nencoding: raw\n";
  for (const std::string fields :
       {"sizes: 3 4 2 1\nspace directions: (1,0,0) (0,2,0) (0,0,3) none\n",
        "sizes: 1 3 4 2\nspace directions: none (1,0,0) (0,2,0) (0,0,3)\n", "sizes: 3 4 2 1\nspacings: 1 2 3 nan\n"}) {
    INFO(fields);
    const Image image = load_image(write("four.nrrd", nrrd + fields + "\n" + raw));
    check_values(image);
    CHECK(image.steps.diagonal() == Vector3(1, 2, 3));
  }
  const Image meta = load_image(
      write("four.mha",
            "NDims = 4\nDimSize = 3 4 2 1\nElementType = MET_UCHAR\nElementSpacing = 1 2 3 1\nOffset = 5 6 7 0\n"
            "TransformMatrix = 0 1 0 0 -1 0 0 0 0 0 1 0 0 0 0 1\nElementDataFile = LOCAL\n" +
                raw));
  check_values(meta);
  CHECK(meta.steps.col(0) == Vector3(0, 1, 0));
  CHECK(meta.steps.col(1) == Vector3(-2, 0, 0));
}

TEST_CASE("image: a header is checked before its data are read", "[image]") {
  for (const std::string name : {"c.nii", "c.nii.gz"}) {
    Nifti own(64);
    for (const std::size_t axis : {42, 44, 46}) own.put(axis, std::int16_t{1000});
    const std::string path = write(name, name == "c.nii" ? own.header : packed(own.header));
    CHECK_THROWS_WITH(load_image(path, [](const ImageGrid& grid) { throw InputError(std::to_string(grid.voxels())); }),
                      "1000000000");
  }
}

TEST_CASE("image: bytes changed at random end in a message or an image", "[image][slow]") {
  std::mt19937_64 generator(7);
  const std::string whole = Nifti(4).header + numbers<std::int16_t>();
  for (int trial = 0; trial < 300; ++trial) {
    std::string bytes = whole;
    for (int change = 0; change < 4; ++change) bytes[generator() % bytes.size()] = static_cast<char>(generator());
    bytes.resize(generator() % 4 ? bytes.size() : generator() % bytes.size());
    message_of(write("r.nii", bytes));
    message_of(write("r.nii.gz", packed(bytes)));
  }
  SUCCEED();
}
