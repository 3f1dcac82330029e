#include "world/runtime/history/bookmark_generator.hpp"

#include <new>
#include <optional>
#include <variant>

namespace aprsim::world {
namespace {

std::optional<api::BookmarkKind> kind_of(api::CellEventKind kind) {
  switch (kind) {
    case api::CellEventKind::kGrasped:
      return api::BookmarkKind::kGrasp;
    case api::CellEventKind::kReleased:
      return api::BookmarkKind::kRelease;
    case api::CellEventKind::kProtectiveStop:
      return api::BookmarkKind::kProtectiveStop;
    case api::CellEventKind::kLost:
    case api::CellEventKind::kFaultBegun:
    case api::CellEventKind::kDriveTripped:
      return api::BookmarkKind::kFault;
    case api::CellEventKind::kWorldStopped:
      return api::BookmarkKind::kStopped;
    case api::CellEventKind::kCommandBegun:
    case api::CellEventKind::kReported:
      return api::BookmarkKind::kCommand;
    case api::CellEventKind::kCommandFailed:
    case api::CellEventKind::kRefused:
      return api::BookmarkKind::kRefusal;
    default:
      return std::nullopt;
  }
}

/// The text of an event's bookmark after the names.
std::string words_of(const api::CellEvent& event) {
  switch (event.kind) {
    case api::CellEventKind::kGrasped:
      return "grasp";
    case api::CellEventKind::kReleased:
      return event.text.empty() ? "release" : "release, " + event.text;
    case api::CellEventKind::kLost:
      return "lost";
    case api::CellEventKind::kProtectiveStop:
      return "protective stop: " + event.text;
    case api::CellEventKind::kFaultBegun:
      return "fault: " + event.text;
    case api::CellEventKind::kDriveTripped:
      return "drive tripped: " + event.text;
    case api::CellEventKind::kCommandFailed:
      return "failed: " + event.text;
    case api::CellEventKind::kRefused:
      return "refused: " + event.text;
    default:
      return event.text;
  }
}

/// The text of the bookmark of a command that no event reports.
std::optional<std::string> text_of(const api::Command& command) {
  if (std::holds_alternative<api::ConveyorCommand>(command.body)) return "belt: command";
  if (std::holds_alternative<api::SceneCommand>(command.body)) return "the scene is changed";
  if (std::holds_alternative<api::SetSignals>(command.body)) return "device: inputs are set";
  if (const auto* intruder = std::get_if<api::SetIntruder>(&command.body)) {
    return intruder->intruder ? "intruder placed" : "intruder removed";
  }
  return std::nullopt;
}

}  // namespace

void BookmarkGenerator::applied(RunTime time, const QueuedCommand& command, const Error* failure) {
  const api::Moment moment{time.epoch, time.step};
  if (failure != nullptr) {
    add(moment, api::BookmarkKind::kRefusal, "refused: " + failure->message);
  } else if (const auto text = text_of(command.command)) {
    add(moment, api::BookmarkKind::kCommand, *text);
  }
}

void BookmarkGenerator::happened(const api::CellEventPtr& event) {
  const auto kind = kind_of(event->kind);
  if (!kind) return;
  std::string text;
  for (const std::string& name : event->names) text += (text.empty() ? "" : ", ") + name;
  const std::string words = words_of(*event);
  if (!words.empty()) text += (text.empty() ? "" : ": ") + words;
  add({event->epoch, event->step}, *kind, text);
}

void BookmarkGenerator::add(api::Moment moment, api::BookmarkKind kind, const std::string& text) {
  try {
    bookmarks_.add(moment, kind, text);
  } catch (const std::bad_alloc&) {
    // The history is complete without this bookmark.
  }
}

}  // namespace aprsim::world
