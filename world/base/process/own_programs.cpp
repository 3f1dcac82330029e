#include "world/base/process/own_programs.hpp"

#include <filesystem>

namespace aprsim::process {
namespace {

namespace fs = std::filesystem;

fs::path own_directory() {
  std::error_code status;
  return fs::read_symlink("/proc/self/exe", status).parent_path();
}

}  // namespace

std::string program_beside(const std::string& name) {
  const fs::path beside = own_directory() / name;
  std::error_code status;
  return fs::is_regular_file(beside, status) ? beside.string() : name;
}

std::string kitting_program(const std::string& name) {
  const fs::path installed = own_directory().parent_path() / "share/aprsim/kitting" / name;
  std::error_code status;
  return fs::is_regular_file(installed, status) ? installed.string()
                                                : APRSIM_KITTING + ('/' + name);
}

std::string python_packages() {
  const fs::path installed = own_directory().parent_path() / "lib/python3/dist-packages/aprsim";
  std::error_code status;
  return fs::is_directory(installed, status) ? "" : APRSIM_PYTHON;
}

std::string web_directory() {
  return (own_directory().parent_path() / "share" / "aprsim" / "web").string();
}

std::string documents_directory() {
  return (own_directory().parent_path() / "share" / "aprsim" / "docs").string();
}

}  // namespace aprsim::process
