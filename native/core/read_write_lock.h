// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"

namespace sinew {

/// A call within another call, in its progress callback, needs an object that is being bound, or it would
/// bind one that is in use. It cannot wait: the outer call could be what it waits for.
class ObjectInUse : public Error
{
    using Error::Error;
};

/// Who may use an object now: any number of calls that read it, or one call that changes it. A call waits for
/// its turn, and those that change go first. A thread that uses an object already does not wait, but gets
/// ObjectInUse, so no two threads wait for each other.
class ReadWriteLock
{
public:
    ReadWriteLock() = default;
    /// For objects that are moved while nobody uses them.
    ReadWriteLock(ReadWriteLock&&) noexcept {}

private:
    friend class AccessLock;

    int readers_ = 0;
    int waiting_ = 0; ///< calls that want to change the object
    bool changing_ = false;
};

/// Holds one object, or two together, until it is destroyed, by the thread that made it.
class AccessLock
{
public:
    enum Kind { reading, changing };

    /// \throw ObjectInUse
    AccessLock(Kind kind, ReadWriteLock& object) : AccessLock(kind, object, object) {}
    /// \param other  may be the same object.
    AccessLock(Kind kind, ReadWriteLock& object, ReadWriteLock& other);
    ~AccessLock();
    AccessLock(const AccessLock&) = delete;
    AccessLock& operator=(const AccessLock&) = delete;

private:
    bool take(bool patient);
    template <class Change>
    void each(Change&& change)
    {
        change(object_);
        if (&other_ != &object_)
            change(other_);
    }

    Kind kind_;
    ReadWriteLock &object_, &other_;
};

} // namespace sinew
