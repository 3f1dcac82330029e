#include "server/journal/run_header.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string>

#include <fmt/format.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/build_identity.hpp"
#include "server/journal/digest.hpp"
#include "server/journal/utf8_strings.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/devices/device_group.hpp"
#include "world/devices/extension.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server::journal {
namespace {

/// Its make, and whether the C library's functions use fused operations on it.
std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  std::string name = "unknown";
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    name = line.substr(std::min(line.find(": ") + 2, line.size()));
    break;
  }
#if defined(__x86_64__)
  name += __builtin_cpu_supports("fma") ? ", with FMA" : ", without FMA";
  name += __builtin_cpu_supports("avx2") ? ", with AVX2" : ", without AVX2";
#endif
  return name;
}

std::string draw_id() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}", device(), device());
}

Result<std::string> content_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (!in) return fail(ErrorCode::kUnavailable, "journal", file + " cannot be read");
  return bytes;
}

}  // namespace

v1::JournalHeader header_here() {
  v1::JournalHeader header;
  header.set_format(aprsim::journal::kFormat);
  header.set_state_version(world::kStateVersion);
  header.set_compiler(__VERSION__);
  header.set_processor(processor());
  header.set_world_sha256(kWorldSha256);
  header.set_build(kBuild);
  return header;
}

Result<v1::JournalFile> model_message(const std::string& file) {
  auto bytes = content_of(file);
  if (!bytes) return tl::unexpected(bytes.error());
  v1::JournalFile model;
  model.set_name(std::filesystem::path(file).filename().string());
  model.set_sha256(sha256(*bytes));
  model.set_content(*std::move(bytes));
  make_utf8(model);
  return model;
}

Result<v1::JournalHeader> header_of(const scene::Scene& scene) {
  v1::JournalHeader header = header_here();
  header.set_run_id(draw_id());
  auto text = scene::portable_text(scene.text, scene.file);
  if (!text) return tl::unexpected(text.error());
  header.set_scene(scene.name);
  header.set_scene_sha256(sha256(*text));
  header.set_scene_text(*std::move(text));
  std::set<std::string> models;
  for (const auto& robot : scene.robots) models.insert(robot.model_file);
  for (const std::string& file : models) {
    // They come with the journal, wherever it is read.
    auto model = model_message(file);
    if (!model) return tl::unexpected(model.error());
    *header.add_models() = *std::move(model);
  }
  // So that a library which is missing is named at its place in the scene.
  if (auto ok = devices::check_devices(scene, scene.file); !ok) return tl::unexpected(ok.error());
  const std::vector<std::string> directories = scene::default_data_paths().extensions;
  std::set<std::string> extensions;
  for (const auto& device : scene.devices) extensions.insert(device.extension);
  for (const std::string& name : extensions) {
    const auto bytes = content_of(devices::find_extension(name, directories));
    if (!bytes) return tl::unexpected(bytes.error());
    auto& extension = *header.add_extensions();
    extension.set_name(name);
    extension.set_sha256(sha256(*bytes));
  }
  make_utf8(header);
  return header;
}

}  // namespace aprsim::server::journal
