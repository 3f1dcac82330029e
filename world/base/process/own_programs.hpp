#pragma once

#include <string>

/// Where the programs and the page of this installation are, or of this build tree. Thread: any.
namespace aprsim::process {

/// A program beside the one that runs; its bare name, for PATH, when there is none.
[[nodiscard]] std::string program_beside(const std::string& name);
/// A controller of clients/kitting, for python3: that of the installation, else of the source tree.
[[nodiscard]] std::string kitting_program(const std::string& name = "kitting");
/// Directory of the Python package for PYTHONPATH; empty where it is installed for the system.
[[nodiscard]] std::string python_packages();
/// Where the web page's files are: ../share/aprsim/web of the running binary, in a build tree as in
/// an installation.
[[nodiscard]] std::string web_directory();
/// Directory of the documents' site: ../share/aprsim/docs of the running binary. docs/build makes
/// it.
[[nodiscard]] std::string documents_directory();

}  // namespace aprsim::process
