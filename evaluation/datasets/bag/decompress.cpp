#include "evaluation/datasets/bag/decompress.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

namespace cornerfix::evaluation {

namespace {

Error damaged(std::string message) { return {ErrorCode::kMalformed, std::move(message), ""}; }

/// Output that grows block by block up to the stated size and one byte more, so that too much is
/// noticed.
class Output {
 public:
  explicit Output(std::size_t stated_size) : limit_(stated_size + 1) {}

  /// Room for the next bytes; empty when the limit is reached.
  std::span<std::byte> room() {
    constexpr std::size_t kBlockBytes = std::size_t{1} << 20U;
    if (bytes_.size() == used_) bytes_.resize(std::min(limit_, used_ + kBlockBytes));
    return std::span(bytes_).subspan(used_);
  }
  void use(std::size_t count) { used_ += count; }

  Result<std::vector<std::byte>> take() && {
    if (used_ + 1 != limit_) {
      return damaged("the chunk unpacks to " + std::string(used_ == limit_ ? "more" : "fewer") +
                     " bytes than the " + std::to_string(limit_ - 1) + " stated");
    }
    return std::move(*this).take_all();
  }

  /// Of any size up to the limit.
  Result<std::vector<std::byte>> take_all() && {
    if (used_ == limit_) return damaged("unpacks to more than " + std::to_string(limit_ - 1));
    bytes_.resize(used_);
    return std::move(bytes_);
  }

 private:
  std::size_t limit_;
  std::size_t used_ = 0;
  std::vector<std::byte> bytes_;
};

using ZstdStream = std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)>;

// The C interfaces take characters.
char* as_chars(std::byte* bytes) { return reinterpret_cast<char*>(bytes); }  // NOLINT

Result<std::vector<std::byte>> unpack_bz2(std::span<const std::byte> packed, std::size_t size) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return damaged("bz2 cannot start");
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> end(&stream, BZ2_bzDecompressEnd);
  stream.next_in = as_chars(const_cast<std::byte*>(packed.data()));  // NOLINT: only read
  stream.avail_in = static_cast<unsigned>(packed.size());
  Output output(size);
  int status = BZ_OK;
  while (status == BZ_OK) {
    const std::span<std::byte> room = output.room();
    if (room.empty()) break;
    stream.next_out = as_chars(room.data());
    stream.avail_out = static_cast<unsigned>(room.size());
    const unsigned in_before = stream.avail_in;
    status = BZ2_bzDecompress(&stream);
    const std::size_t written = room.size() - stream.avail_out;
    output.use(written);
    if (status == BZ_OK && written == 0 && stream.avail_in == in_before) break;
  }
  if (status != BZ_OK && status != BZ_STREAM_END) return damaged("the bz2 chunk is damaged");
  return std::move(output).take();
}

Result<std::vector<std::byte>> unpack_lz4(std::span<const std::byte> packed, std::size_t size) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0U) {
    return damaged("lz4 cannot start");
  }
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> end(
      context, LZ4F_freeDecompressionContext);
  Output output(size);
  std::size_t wanted = 1;
  while (wanted != 0) {
    const std::span<std::byte> room = output.room();
    std::size_t written = room.size();
    std::size_t read = packed.size();
    wanted = LZ4F_decompress(context, room.data(), &written, packed.data(), &read, nullptr);
    if (LZ4F_isError(wanted) != 0U) return damaged("the lz4 chunk is damaged");
    output.use(written);
    packed = packed.subspan(read);
    if (written == 0 && read == 0) break;
  }
  return std::move(output).take();
}

/// One frame, as far as there is room.
std::optional<Error> unpack_zstd(std::span<const std::byte> packed, Output& output) {
  const ZstdStream stream(ZSTD_createDStream(), ZSTD_freeDStream);
  if (stream == nullptr) return damaged("zstd cannot start");
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  std::size_t wanted = 1;
  while (wanted != 0) {
    const std::span<std::byte> room = output.room();
    const std::size_t in_before = in.pos;
    ZSTD_outBuffer out{room.data(), room.size(), 0};
    wanted = ZSTD_decompressStream(stream.get(), &out, &in);
    if (ZSTD_isError(wanted) != 0U) return damaged("the zstd chunk is damaged");
    output.use(out.pos);
    if (out.pos > 0 || in.pos > in_before) continue;
    if (room.empty()) break;  // At the limit, which the caller notices.
    return damaged("the zstd data are cut off");
  }
  return std::nullopt;
}

Result<void> unpack_zstd_file(const std::filesystem::path& packed,
                              const std::filesystem::path& unpacked) {
  std::ifstream from(packed, std::ios::binary);
  std::ofstream to(unpacked, std::ios::binary | std::ios::trunc);
  const ZstdStream stream(ZSTD_createDStream(), ZSTD_freeDStream);
  if (!from || !to || stream == nullptr) return damaged("cannot be unpacked");
  std::vector<std::byte> in(ZSTD_DStreamInSize());
  std::vector<std::byte> out(ZSTD_DStreamOutSize());
  std::size_t wanted = 0;
  while (from.read(as_chars(in.data()), static_cast<std::streamsize>(in.size())),
         from.gcount() > 0) {
    ZSTD_inBuffer input{in.data(), static_cast<std::size_t>(from.gcount()), 0};
    while (input.pos < input.size) {
      ZSTD_outBuffer output{out.data(), out.size(), 0};
      wanted = ZSTD_decompressStream(stream.get(), &output, &input);
      if (ZSTD_isError(wanted) != 0U) return damaged("the zstd file is damaged");
      to.write(as_chars(out.data()), static_cast<std::streamsize>(output.pos));
    }
  }
  to.close();
  if (!to) return Error{ErrorCode::kStorageFull, "cannot be unpacked to " + unpacked.string(), ""};
  if (wanted != 0) return damaged("the zstd file is cut off");
  return {};
}

/// Keeps what a file holds that is cut off.
Result<void> unpack_gzip_file(const std::filesystem::path& packed,
                              const std::filesystem::path& unpacked) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> from(gzopen(packed.c_str(), "rb"), gzclose);
  std::ofstream to(unpacked, std::ios::binary | std::ios::trunc);
  if (from == nullptr || !to) return damaged("cannot be unpacked");
  std::vector<std::byte> block(std::size_t{256} << 10U);
  int size = 0;
  while ((size = gzread(from.get(), block.data(), static_cast<unsigned>(block.size()))) > 0) {
    to.write(as_chars(block.data()), size);
  }
  to.close();
  if (!to) return Error{ErrorCode::kStorageFull, "cannot be unpacked to " + unpacked.string(), ""};
  if (size < 0) return damaged("the gzip file is damaged");
  return {};
}

}  // namespace

bool is_gzip(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

bool is_zstd(std::span<const std::byte> bytes) {
  constexpr std::array kMagic = {std::byte{0x28}, std::byte{0xb5}, std::byte{0x2f},
                                 std::byte{0xfd}};
  return bytes.size() >= kMagic.size() && std::ranges::equal(bytes.first(kMagic.size()), kMagic);
}

Result<std::vector<std::byte>> decompress_message(std::span<const std::byte> packed) {
  Output output(kMaxChunkBytes);
  if (auto error = unpack_zstd(packed, output)) return *error;
  return std::move(output).take_all();
}

std::vector<std::byte> magic_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 4> bytes{};
  file.read(bytes.data(), bytes.size());
  const auto read = std::as_bytes(std::span(bytes).first(static_cast<std::size_t>(file.gcount())));
  return {read.begin(), read.end()};
}

Result<void> decompress_file(const std::filesystem::path& packed,
                             const std::filesystem::path& unpacked) {
  return is_gzip(magic_bytes(packed)) ? unpack_gzip_file(packed, unpacked)
                                      : unpack_zstd_file(packed, unpacked);
}

Result<std::vector<std::byte>> decompress(std::string_view compression,
                                          std::span<const std::byte> packed, std::size_t size) {
  if (size > kMaxChunkBytes) {
    return Error{ErrorCode::kTooLarge,
                 "a chunk of " + std::to_string(size) + " bytes, above the limit of " +
                     std::to_string(kMaxChunkBytes),
                 ""};
  }
  if (compression == "bz2") return unpack_bz2(packed, size);
  if (compression == "lz4") return unpack_lz4(packed, size);
  if (compression == "zstd") {
    Output output(size);
    if (auto error = unpack_zstd(packed, output)) return *error;
    return std::move(output).take();
  }
  if (compression.empty() || compression == "none") {
    if (packed.size() != size) return damaged("the chunk has not the size stated");
    return std::vector<std::byte>(packed.begin(), packed.end());
  }
  return damaged("unknown compression '" + std::string(compression) + "'");
}

}  // namespace cornerfix::evaluation
