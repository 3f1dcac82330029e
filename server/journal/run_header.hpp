#pragma once

#include <string>

#include "aprsim/v1/journal.pb.h"
#include "world/base/result.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// A header with the fields of this program: format, build, compiler, processor. Thread: any.
[[nodiscard]] v1::JournalHeader header_here();

/// A header with the fields of this program and of the scene: its text and models, with digests.
/// Errors: a file that cannot be read. Thread: any.
[[nodiscard]] Result<v1::JournalHeader> header_of(const scene::Scene& scene);

/// A robot description with its digest; its name is the file's. Errors: it cannot be read. Thread:
/// any.
[[nodiscard]] Result<v1::JournalFile> model_message(const std::string& file);

}  // namespace aprsim::server::journal
