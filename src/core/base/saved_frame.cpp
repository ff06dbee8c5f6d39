#include "base/saved_frame.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include <tanor/error.hpp>

#include "base/checksum.hpp"
#include "base/text.hpp"

namespace tanor::detail {

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  Checksum sum;
  sum.add(bytes);
  return sum.value();
}

std::span<const std::byte> check_frame(std::span<const std::byte> bytes, const SavedHeader& wanted, const SavedBy& by) {
  const auto refuse = [&](const std::string& why) { throw InputError(by.where, why); };
  SavedHeader header;
  std::uint64_t sum = 0;
  const std::size_t compared = std::min(bytes.size(), sizeof header.magic);
  if (compared == 0 || std::memcmp(bytes.data(), wanted.magic.data(), compared) != 0)
    refuse(std::string("these are no bytes that ") + by.writer + " saved");
  if (bytes.size() < sizeof header + sizeof sum) refuse("it ends too early");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.byte_order != wanted.byte_order) refuse("it was saved on a machine with another order of bytes");
  if (header.version != wanted.version)
    refuse("its format is " + text(header.version) + ", this version of tanor reads " + text(wanted.version));
  std::memcpy(&sum, bytes.last(sizeof sum).data(), sizeof sum);
  if (sum != checksum_of(bytes.first(bytes.size() - sizeof sum)))
    refuse("it is damaged or cut off: its checksum is another one");
  if (header.fingerprint != wanted.fingerprint) refuse(std::string("it belongs to ") + by.owner);
  return bytes.subspan(sizeof header, bytes.size() - sizeof header - sizeof sum);
}

}  // namespace tanor::detail
