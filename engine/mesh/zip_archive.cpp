#include "engine/mesh/zip_archive.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <minizip/unzip.h>

namespace voidpath::mesh {

namespace {

/// Model text packs to a tenth or so; beyond this ratio, in parts of more than kRatioFrom bytes, an archive
/// is made to exhaust its reader.
constexpr std::size_t kMaxRatio = 100;
constexpr std::size_t kRatioFrom = std::size_t{32} << 20;
constexpr int kIgnoreCase = 2;

/// The archive as a read-only file for minizip.
struct Memory {
  std::string_view bytes;
  std::size_t at = 0;
};

void* ZCALLBACK open_memory(void* opaque, const void*, int) { return opaque; }
int ZCALLBACK close_memory(void*, void*) { return 0; }
int ZCALLBACK memory_error(void*, void*) { return 0; }

uLong ZCALLBACK read_memory(void*, void* stream, void* buffer, uLong size) {
  auto& m = *static_cast<Memory*>(stream);
  const std::size_t n = std::min<std::size_t>(size, m.bytes.size() - m.at);
  if (n > 0) std::memcpy(buffer, m.bytes.data() + m.at, n);
  m.at += n;
  return static_cast<uLong>(n);
}

ZPOS64_T ZCALLBACK tell_memory(void*, void* stream) { return static_cast<Memory*>(stream)->at; }

long ZCALLBACK seek_memory(void*, void* stream, ZPOS64_T offset, int origin) {
  auto& m = *static_cast<Memory*>(stream);
  const std::size_t base = origin == ZLIB_FILEFUNC_SEEK_CUR   ? m.at
                           : origin == ZLIB_FILEFUNC_SEEK_END ? m.bytes.size()
                                                              : 0;
  if (offset > m.bytes.size() - base) return -1;
  m.at = base + static_cast<std::size_t>(offset);
  return 0;
}

}  // namespace

struct ZipArchive::Impl {
  FileBytes file;
  Memory memory;
  unzFile zip = nullptr;
  std::size_t left = 0;
};

ZipArchive::ZipArchive(const FileBytes& file, std::size_t max_bytes) : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->memory.bytes = file.bytes;
  impl_->left = max_bytes;
  zlib_filefunc64_def io{};
  io.zopen64_file = open_memory;
  io.zread_file = read_memory;
  io.ztell64_file = tell_memory;
  io.zseek64_file = seek_memory;
  io.zclose_file = close_memory;
  io.zerror_file = memory_error;
  io.opaque = &impl_->memory;
  impl_->zip = unzOpen2_64(file.name.c_str(), &io);
  if (!impl_->zip) refuse(file, "no zip archive, or one cut short: its directory at the end is missing");
}

ZipArchive::~ZipArchive() {
  if (impl_->zip) unzClose(impl_->zip);
}

bool ZipArchive::has(const std::string& part) const {
  return unzLocateFile(impl_->zip, part.c_str(), kIgnoreCase) == UNZ_OK;
}

void ZipArchive::read(const std::string& part, const std::function<void(std::string_view)>& piece) {
  if (!has(part)) refuse(impl_->file, "part " + part + " is missing in the archive");
  const auto fail = [&](const std::string& what) { refuse(impl_->file, "part " + part + ": " + what); };
  unz_file_info64 info{};
  if (unzGetCurrentFileInfo64(impl_->zip, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK) {
    fail("its directory entry is damaged");
  }
  if (info.flag & 1u) fail("it is encrypted");
  if (unzOpenCurrentFile(impl_->zip) != UNZ_OK) fail("it is damaged, or packed in a way that is not known");
  // Closed on every way out; the checksum is asked for on the good one.
  struct Closer {
    unzFile zip;
    ~Closer() {
      if (zip) unzCloseCurrentFile(zip);
    }
  } closer{impl_->zip};
  std::array<char, 1 << 16> buffer{};
  std::size_t unpacked = 0;
  for (;;) {
    const int n = unzReadCurrentFile(impl_->zip, buffer.data(), static_cast<unsigned>(buffer.size()));
    if (n < 0) fail("it is damaged after " + std::to_string(unpacked) + " bytes");
    if (n == 0) break;
    const auto got = static_cast<std::size_t>(n);
    unpacked += got;
    if (got > impl_->left || (unpacked > kRatioFrom && unpacked / kMaxRatio > info.compressed_size)) {
      fail("it unpacks to more than is reasonable (" + std::to_string(info.compressed_size) +
           " bytes grow to " + std::to_string(unpacked) + " and more)");
    }
    impl_->left -= got;
    piece({buffer.data(), got});
  }
  closer.zip = nullptr;
  if (unzCloseCurrentFile(impl_->zip) != UNZ_OK) fail("its checksum does not fit: the archive is damaged");
}

}  // namespace voidpath::mesh
