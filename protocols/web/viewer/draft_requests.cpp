#include "protocols/web/viewer/draft_requests.hpp"

#include <algorithm>

#include "protocols/messages/write_message.hpp"
#include "protocols/web/topics/topic_message.hpp"
#include "protocols/web/topics/visual_message.hpp"

namespace aprsim::web {
namespace {

Result<void> check_offered(const SceneDrafts* drafts) {
  if (drafts != nullptr) return {};
  return fail(ErrorCode::kFailedPrecondition, "scene",
              "this daemon edits no scene: it replays a run");
}

}  // namespace

Result<void> DraftRequests::write_source(const api::CellDescription& cell,
                                         v1::SceneSource& message) {
  if (auto offered = check_offered(options_.drafts); !offered) return offered;
  const SceneSource source = options_.drafts->source_of(cell);
  message.set_name(cell.scene);
  message.set_text(source.text);
  message.set_as_written(source.as_written);
  for (const TypesFile& types : source.types) {
    auto& out = *message.add_types();
    out.set_file(types.file);
    out.set_text(types.text);
  }
  return {};
}

Result<void> DraftRequests::build(std::uint64_t viewer, const v1::ViewerRequest& request,
                                  const std::string& name) {
  if (auto offered = check_offered(options_.drafts); !offered) return offered;
  if (!pending_.insert(viewer).second) {
    return fail(ErrorCode::kUnavailable, "draft", "the last draft is still being built");
  }
  options_.drafts->build(request.draft_scene().text(), name,
                         [mailbox = mailbox_, viewer, id = request.id()](Result<SceneDraft> draft) {
                           const std::lock_guard lock(mailbox->mutex);
                           mailbox->answers.push_back({viewer, id, std::move(draft)});
                         });
  return {};
}

std::vector<DraftRequests::Answer> DraftRequests::take_answers() {
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mailbox_->mutex);
    answers.swap(mailbox_->answers);
  }
  for (const Answer& answer : answers) pending_.erase(answer.viewer);
  return answers;
}

void DraftRequests::write(const Answer& answer, v1::SceneDraft& message) const {
  const api::Snapshot& snapshot = *answer.draft->snapshot;
  message.set_id(answer.request);
  write_without_names(snapshot, instance_id_, *message.mutable_snapshot());
  protocols::write_message(*snapshot.cell, *message.mutable_cell());
  if (options_.visual)
    write_message(options_.visual(*snapshot.cell), *message.mutable_appearance());
  for (const SceneDraft::Reach& reach : answer.draft->reaches) {
    auto& out = *message.add_reaches();
    out.set_robot(static_cast<std::uint32_t>(reach.robot));
    out.set_body(static_cast<std::uint32_t>(reach.body));
    for (const std::size_t slot : reach.slots) out.add_slots(static_cast<std::uint32_t>(slot));
  }
  const RobotModels models = options_.models();
  for (const SceneDraft::Model& model : answer.draft->models) {
    const bool known = std::ranges::any_of(models, [&model](const auto& present) {
      return present.first == model.robot && present.second == model.file;
    });
    if (known) continue;
    auto& out = *message.add_models();
    out.set_robot(model.robot);
    out.set_text(model.text);
  }
}

}  // namespace aprsim::web
