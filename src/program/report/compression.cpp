#include "report/compression.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

#if TANOR_HAS_ZLIB
#include <zlib.h>
#endif

namespace tanor::report {

namespace {

constexpr int with_gzip_head = 15 + 16, with_zlib_head = 15;  // window bits of deflateInit2

#if TANOR_HAS_ZLIB

/// Compresses all bytes. Throws std::bad_alloc if memory runs out; no other failure is expected.
std::string deflate_all(std::string_view bytes, int window_bits) {
  constexpr int level = 6;
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
  std::string result(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  const int end = deflate(&stream, Z_FINISH);
  deflateEnd(&stream);
  if (end != Z_STREAM_END) throw std::runtime_error("zlib could not compress");
  result.resize(stream.total_out);
  return result;
}

/// Unpacks bytes with zlib's head. Returns false if they are not `size` bytes.
bool inflate_all(std::string_view packed, char* to, std::size_t size) {
  auto found = static_cast<uLongf>(size);
  return uncompress(reinterpret_cast<Bytef*>(to), &found, reinterpret_cast<const Bytef*>(packed.data()),
                    static_cast<uLong>(packed.size())) == Z_OK &&
         found == size;
}

#else

std::string deflate_all(std::string_view, int) {
  throw std::runtime_error("this tanor was built without zlib");
}
bool inflate_all(std::string_view, char*, std::size_t) {
  throw std::runtime_error("this tanor was built without zlib");
}

#endif

}  // namespace

bool has_compression() {
  return TANOR_HAS_ZLIB != 0;
}

std::string gzip(std::string_view bytes) {
  constexpr std::size_t most = std::size_t{1} << 30;  // zlib counts in 32 bits; another member costs 18 bytes
  std::string members;
  do {
    members += deflate_all(bytes.substr(0, most), with_gzip_head);
    bytes.remove_prefix(std::min(most, bytes.size()));
  } while (!bytes.empty());
  return members;
}

std::string compress_for_vtk(std::string_view bytes) {
  constexpr std::size_t block_size = 1 << 20;
  // The header holds the number of blocks, their size, the size of the last one if it is shorter, and the compressed
  // size of each block.
  std::vector<std::uint64_t> head{0, block_size, bytes.size() % block_size};
  std::string blocks;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(block_size, bytes.size()))) {
    const std::string block = deflate_all(bytes.substr(0, block_size), with_zlib_head);
    blocks += block;
    head.push_back(block.size());
    ++head[0];
  }
  return std::string(reinterpret_cast<const char*>(head.data()), head.size() * sizeof head[0]) + blocks;
}

std::optional<std::string> decompress_for_vtk(std::string_view bytes, std::size_t size) {
  std::uint64_t head[3];  // number of blocks, their size, size of the last one if it is shorter
  if (bytes.size() < sizeof head) return {};
  std::memcpy(head, bytes.data(), sizeof head);
  bytes.remove_prefix(sizeof head);
  const std::uint64_t count = head[0], block_size = head[1];
  if (count > bytes.size() / sizeof count || (count > 0 && (block_size == 0 || (size - 1) / block_size + 1 != count)))
    return {};
  std::vector<std::uint64_t> sizes(count);
  if (count > 0) std::memcpy(sizes.data(), bytes.data(), count * sizeof sizes[0]);
  bytes.remove_prefix(count * sizeof count);
  std::string result(size, '\0');
  std::size_t done = 0;
  for (const std::uint64_t packed : sizes) {
    if (packed > bytes.size()) return {};
    const std::size_t there = std::min<std::uint64_t>(block_size, size - done);
    if (!inflate_all(bytes.substr(0, packed), &result[done], there)) return {};
    done += there;
    bytes.remove_prefix(packed);
  }
  return done == size ? std::optional(std::move(result)) : std::nullopt;
}

}  // namespace tanor::report
