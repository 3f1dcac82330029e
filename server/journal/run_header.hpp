#pragma once

#include "aprsim/v1/journal.pb.h"
#include "world/base/result.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// A journal's header as far as this program tells it: format, build, compiler, processor. Thread:
/// any.
[[nodiscard]] v1::JournalHeader header_here();

/// A journal's header as far as scene and program tell it: the scene's text and its models whole,
/// with digests, compiler and processor. Errors: of what it had to read. Thread: any.
[[nodiscard]] Result<v1::JournalHeader> header_of(const scene::Scene& scene);

}  // namespace aprsim::server::journal
