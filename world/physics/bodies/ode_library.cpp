#include "world/physics/bodies/ode_library.hpp"

#include <cstdarg>
#include <cstdio>
#include <string>

#include <ode/ode.h>

#include "world/physics/bodies/physics_failure.hpp"

namespace aprsim::physics {
namespace {

[[noreturn]] void raise(const char* kind, int number, const char* format, va_list arguments) {
  char text[512];
  std::vsnprintf(text, sizeof text, format, arguments);
  throw PhysicsFailure(std::string("ODE ") + kind + " " + std::to_string(number) + ": " + text);
}

void on_error(int number, const char* format, va_list arguments) {
  raise("error", number, format, arguments);
}

void on_debug(int number, const char* format, va_list arguments) {
  raise("assertion", number, format, arguments);
}

// The simulation thread must not write to any stream.
void drop_message(int, const char*, va_list) {}

/// ODE, initialised once per process, with handlers that throw instead of ending the process.
struct Library {
  Library() {
    dInitODE2(0);
    dSetErrorHandler(on_error);
    dSetDebugHandler(on_debug);
    dSetMessageHandler(drop_message);
  }
};

}  // namespace

void prepare_ode() {
  // ODE requires one initialisation per process and per-thread data before dCollide.
  static const Library library;
  static thread_local const int ready =
      dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll));
  if (ready == 0) throw PhysicsFailure("ODE could not allocate its data for this thread");
}

bool ode_keeps_asserts() { return dCheckConfiguration("ODE_EXT_no_debug") == 0; }

}  // namespace aprsim::physics
