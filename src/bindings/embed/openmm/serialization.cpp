#include <openmm/serialization/SerializationNode.h>
#include <openmm/serialization/SerializationProxy.h>

#include <memory>
#include <typeinfo>

#include "embed/openmm/tanor_openmm.hpp"

namespace tanor::embed {

namespace {

/// Serializes ExactConstraints for XmlSerializer and for copies of a System in Python.
class ExactConstraintsProxy : public OpenMM::SerializationProxy {
 public:
  ExactConstraintsProxy() : SerializationProxy("TanorExactConstraints") {}

  void serialize(const void* object, OpenMM::SerializationNode& node) const override {
    const auto& force = *static_cast<const ExactConstraints*>(object);
    node.setIntProperty("version", 1);
    node.setIntProperty("forceGroup", force.getForceGroup());
    node.setStringProperty("name", force.getName());
    node.setIntProperty("threads", force.threads());
    OpenMM::SerializationNode& constraints = node.createChildNode("Constraints");
    for (const DistanceConstraint& one : force.added()) {
      constraints.createChildNode("Constraint")
          .setIntProperty("p1", one.particle1)
          .setIntProperty("p2", one.particle2)
          .setDoubleProperty("d", one.distance);
    }
  }

  void* deserialize(const OpenMM::SerializationNode& node) const override {
    if (node.getIntProperty("version") != 1) throw OpenMM::OpenMMException("ExactConstraints: unknown version");
    auto force = std::make_unique<ExactConstraints>(node.getIntProperty("threads"));
    force->setForceGroup(node.getIntProperty("forceGroup"));
    force->setName(node.getStringProperty("name"));
    for (const OpenMM::SerializationNode& one : node.getChildNode("Constraints").getChildren())
      force->addConstraint(one.getIntProperty("p1"), one.getIntProperty("p2"), one.getDoubleProperty("d"));
    return force.release();
  }
};

/// The proxy is registered when the library is loaded.
[[maybe_unused]] const bool is_registered = [] {
  OpenMM::SerializationProxy::registerProxy(typeid(ExactConstraints), new ExactConstraintsProxy);
  return true;
}();

}  // namespace

}  // namespace tanor::embed
