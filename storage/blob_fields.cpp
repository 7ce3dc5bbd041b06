#include "storage/blob_fields.hpp"

#include <string>

namespace cornerfix::storage {

Error corrupt(std::string_view what, std::string_view why) {
  return Error{ErrorCode::kCorruptData, std::string(what) + ": " + std::string(why), ""};
}

Error inconsistent(std::string_view what) { return corrupt(what, "fields contradict each other"); }

Result<BlobReader> open_blob(BlobKind kind, std::string_view what, BlobView blob) {
  if (blob.size() < kHeaderSize + kChecksumSize) return corrupt(what, "cut short");
  if (blob[0] < 1 || blob[0] > newest_version(kind)) {
    return corrupt(what, "version " + std::to_string(blob[0]) + ", known up to " +
                             std::to_string(newest_version(kind)));
  }
  if (blob[1] != static_cast<std::uint8_t>(kind)) return corrupt(what, "bytes of another kind");
  const BlobView content = blob.first(blob.size() - kChecksumSize);
  if (crc_32(content) != checksum_of(blob)) return corrupt(what, "wrong checksum");
  return BlobReader(content.subspan(kHeaderSize));
}

std::uint32_t checksum_of(BlobView blob) {
  assert(blob.size() >= kHeaderSize + kChecksumSize && "not a BLOB of this codec");
  return load_little_endian<std::uint32_t>(blob.last(kChecksumSize).data());
}

}  // namespace cornerfix::storage
