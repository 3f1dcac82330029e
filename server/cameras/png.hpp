#pragma once

#include <cstdint>
#include <string>

#include "world/base/result.hpp"
#include "world/render/picture.hpp"

namespace aprsim::server {

/// A picture as a PNG file, compressed fast. Error: kUnavailable, with the library's message.
/// Thread: any.
[[nodiscard]] Result<std::string> png_of(const render::Picture<std::uint8_t>& rgb);

}  // namespace aprsim::server
