#include "storage/digest.hpp"

#include <openssl/evp.h>

#include <memory>
#include <span>
#include <stdexcept>

namespace cornerfix::storage {
namespace {

using Sha256 = std::array<std::uint8_t, 32>;

Sha256 sha256(BlobView first, BlobView second) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        &EVP_MD_CTX_free);
  Sha256 digest{};
  const bool done = context != nullptr &&
                    EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1 &&
                    EVP_DigestUpdate(context.get(), first.data(), first.size()) == 1 &&
                    EVP_DigestUpdate(context.get(), second.data(), second.size()) == 1 &&
                    EVP_DigestFinal_ex(context.get(), digest.data(), nullptr) == 1;
  if (!done) throw std::runtime_error("SHA-256 is not available");
  return digest;
}

std::string to_hex(const Sha256& digest) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  for (const std::uint8_t byte : digest) {
    hex += kDigits[byte >> 4];
    hex += kDigits[byte & 0xF];
  }
  return hex;
}

}  // namespace

KeyFrameChain extend(const KeyFrameChain& chain, BlobView key_frame) {
  return sha256(chain, key_frame);
}

KeyFrameChain hash_of(const OccupancyGrid& floor_map) {
  const Blob header = encode_grid_header(floor_map);
  return sha256(header, BlobView(reinterpret_cast<const std::uint8_t*>(floor_map.cells.data()),
                                 floor_map.cells.size()));
}

std::string map_digest(std::string_view parameters_json, const KeyFrameChain& chain, bool drifts) {
  constexpr std::array<std::uint8_t, 6> kDrifts = {'d', 'r', 'i', 'f', 't', 's'};
  const KeyFrameChain source = drifts ? extend(chain, kDrifts) : chain;
  const auto* parameters = reinterpret_cast<const std::uint8_t*>(parameters_json.data());
  // The chain has a fixed length, so nothing else can be read from the same bytes.
  return to_hex(sha256(source, BlobView(parameters, parameters_json.size())));
}

}  // namespace cornerfix::storage
