#include "core/simulation/tools.h"

#include <algorithm>

#include "core/simulation/simulation_impl.h"
#include "elastin/core/base/error.h"

namespace elastin {
namespace {

/// Position and turn alone: what it does in between follows from where it goes.
Pose checked(const Pose& pose) {
  if (!pose.position.allFinite() || !pose.turn.allFinite())
    throw InputError("the pose of a tool must be of finite numbers");
  if ((pose.turn.transpose() * pose.turn - Matrix3::Identity()).norm() > 1e-9 || !(pose.turn.determinant() > 0))
    throw InputError("the turn of a tool is no rotation: its columns must be orthonormal and right-handed");
  return {pose.turn, pose.position};
}

Tool& found(Tools& tools, ToolId tool) {
  if (tool < 1 || static_cast<std::size_t>(tool) > tools.all.size())
    throw InputError("no tool " + std::to_string(tool) + ": there are " + std::to_string(tools.all.size()) +
                     ", from 1");
  return tools.all[tool - 1];
}

}  // namespace

Pose Tools::pose(ToolId number, double time) const {
  // What is made of the body at rest is the same in whichever step that is.
  if (time == 0 && end > 0) return first[number - 1];
  const Tool& tool = all[number - 1];
  if (!tool.next || !(end > start)) return tool.pose;
  const double span = end - start;
  double part = std::clamp((time - start) / span, 0., 1.);
  if (part > 1 - 1e-9) part = 1;  // the sum of a step's parts is off by its rounding
  const Eigen::AngleAxisd turned(Matrix3(tool.next->turn * tool.pose.turn.transpose()));
  Pose pose;
  pose.position = tool.pose.position + part * (tool.next->position - tool.pose.position);
  pose.turn =
      part == 1 ? tool.next->turn
                : Matrix3(Eigen::AngleAxisd(part * turned.angle(), turned.axis()).toRotationMatrix() * tool.pose.turn);
  pose.velocity = (tool.next->position - tool.pose.position) / span;
  pose.spin = turned.angle() / span * turned.axis();
  return pose;
}

ToolId Simulation::add_tool(const Pose& pose) {
  impl_->tools->first.push_back(checked(pose));
  impl_->tools->all.push_back({impl_->tools->first.back(), std::nullopt});
  return static_cast<ToolId>(impl_->tools->all.size());
}

void Simulation::move_tool(ToolId number, const Vector3& position, const std::optional<Matrix3>& turn) {
  Tool& tool = found(*impl_->tools, number);
  tool.next = checked({turn ? *turn : tool.next.value_or(tool.pose).turn, position});
}

Pose Simulation::tool_pose(ToolId tool) const { return found(*impl_->tools, tool).pose; }

std::function<Pose(double)> Simulation::tool_motion(ToolId tool) const {
  found(*impl_->tools, tool);
  return [tools = impl_->tools, tool](double time) { return tools->pose(tool, time); };
}

}  // namespace elastin
