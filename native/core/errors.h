// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace sinew {

/// Base class of all errors that the library throws on purpose. It carries the indices of the elements at
/// fault, so that a caller can show or select them.
class Error : public std::runtime_error
{
public:
    enum class Element { none, vertex, face, handle };

    explicit Error(const std::string& message, Element kind = Element::none, std::vector<int> elements = {});

    Element element_kind() const { return kind_; }
    const std::vector<int>& elements() const { return elements_; }

private:
    Element kind_;
    std::vector<int> elements_;
};

/// The rest shape cannot be read: an index is out of range, a point is not finite, or there is no vertex.
class InvalidMesh : public Error
{
    using Error::Error;
};

/// Handles, weights, poses or incoming points do not fit the mesh or each other.
class InvalidConstraint : public Error
{
    using Error::Error;
};

/// An option is outside its documented range.
class InvalidOption : public Error
{
    using Error::Error;
};

/// The system has no unique solution, or there is no memory for its factor.
class FactorizationFailed : public Error
{
    using Error::Error;
};

/// A factor would take more memory than limit_memory() allows, or more than the machine has.
class OutOfMemory : public FactorizationFailed
{
    using FactorizationFailed::FactorizationFailed;
};

/// The caller asked to stop; the object is as it was before the call.
class Cancelled : public Error
{
    using Error::Error;
};

/// \throw InvalidOption  `value` is not a finite number of at least `least`.
void require_at_least(double value, double least, const char* name);

/// "3, 17, 20 and 4 more", for messages.
std::string list_some(const std::vector<int>& elements, std::size_t most = 8);

} // namespace sinew
