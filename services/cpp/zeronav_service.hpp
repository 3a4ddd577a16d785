// A service in C++17: the shell's loop, lockstep, checks of received messages and exit codes are those
// of the services in Rust, from the library `zeronav_cpp`.
#pragma once

#include "zeronav.hpp"

#include <exception>
#include <stdexcept>
#include <type_traits>

namespace zeronav {

namespace raw {
struct Context;

struct View {
    const void* envelope;
    const void* items;
    std::size_t len;
    std::uint64_t came_ns;
};

struct Callbacks {
    void* (*open)(Context*);
    void (*wake)(void*, Context*, std::uint64_t);
    void (*close)(void*);
};
}  // namespace raw

/// How the run keeps time, and what launch asks.
struct RunState {
    /// [ns] of run time from tick to tick.
    std::uint64_t tick_ns;
    /// Newest tick that was answered.
    std::uint64_t answered_tick;
    /// 1 in lockstep.
    std::uint8_t lockstep;
    /// 1 when the robot shall stop.
    std::uint8_t stopping;
    /// 1 when there are zones: a guard that does not know them stops.
    std::uint8_t zones;
};

/// Newest odometry.
struct NewestOdometry {
    /// Identity; 0 before the first message.
    std::uint64_t id;
    /// Tick.
    std::uint64_t tick;
    /// [ns] run time.
    std::uint64_t run_ns;
    /// [ns] when it came in.
    std::uint64_t came_ns;
    /// The message.
    Odometry odometry;
};

/// The answer that was begun.
struct Begun {
    /// Tick that is answered; 0 = idle output.
    std::uint64_t tick;
    /// [ns] run time of it.
    std::uint64_t run_ns;
    /// [ns] when all inputs were taken in.
    std::uint64_t started_ns;
};

extern "C" {
int zeronav_run(std::uint16_t role, raw::Callbacks callbacks);
std::int32_t zeronav_reader(raw::Context*, std::size_t topic);
std::int32_t zeronav_writer(raw::Context*, std::size_t topic, std::size_t len);
void zeronav_fail(raw::Context*, const char* why);
RunState zeronav_run_state(raw::Context*);
bool zeronav_awaits(raw::Context*, std::uint16_t role, std::uint64_t tick, std::uint64_t spoken_tick);
NewestOdometry zeronav_newest(raw::Context*);
bool zeronav_pose_at(raw::Context*, std::uint64_t run_ns, Pose*);
bool zeronav_poll(raw::Context*, std::size_t reader);
bool zeronav_get(raw::Context*, std::size_t reader, raw::View*);
std::uint64_t zeronav_spoken_tick(raw::Context*, std::size_t reader);
std::size_t zeronav_due(raw::Context*, std::uint64_t tick, bool complete, std::uint64_t deadline_ns,
                        bool news, std::uint64_t* ticks);
bool zeronav_begin(raw::Context*, std::uint64_t tick, std::uint64_t capture_ns, const Parents*, Begun*);
bool zeronav_send(raw::Context*, std::size_t writer, const void* meta, std::size_t meta_bytes,
                  const void* items, std::size_t item_bytes);
void zeronav_finish(raw::Context*, std::uint64_t work);
void zeronav_refresh(raw::Context*, std::size_t writer);
void zeronav_reason(raw::Context*, std::uint32_t bit, bool holds);
}

/// A message as it lies in shared memory; valid until the next poll of its reader, and not beyond the
/// callback.
template <typename Topic>
struct View {
    const Header* header = nullptr;
    const decltype(Topic::Envelope::meta)* meta = nullptr;
    const typename Topic::Item* items = nullptr;
    std::size_t size = 0;
    /// [ns] when it came in.
    std::uint64_t came_ns = 0;

    /// False before the first message.
    explicit operator bool() const { return header != nullptr; }
    const typename Topic::Item* begin() const { return items; }
    const typename Topic::Item* end() const { return items + size; }
    std::uint64_t id() const { return header ? header->id : 0; }
};

/// Answers that are due: at most two ticks, the idle output as tick 0.
struct Dues {
    std::uint64_t ticks[2];
    std::size_t size;
    const std::uint64_t* begin() const { return ticks; }
    const std::uint64_t* end() const { return ticks + size; }
};

/// What a service may do in a callback. It is valid in this callback only, and on its thread.
class Shell {
public:
    explicit Shell(raw::Context* context) : context_(context) {}

    /// How the run keeps time, and what launch asks.
    RunState run() const { return zeronav_run_state(context_); }
    /// Newest odometry; it was taken in before the callback.
    NewestOdometry odometry() const { return zeronav_newest(context_); }
    /// `odom_from_base` at a run time of the last second; false when that is not known.
    bool pose_at(std::uint64_t run_ns, Pose& pose) const {
        return zeronav_pose_at(context_, run_ns, &pose);
    }
    /// True when an answer to `tick` waits for that of `role`; lockstep only.
    bool awaits(Role role, std::uint64_t tick, std::uint64_t spoken_tick) const {
        return zeronav_awaits(context_, static_cast<std::uint16_t>(role), tick, spoken_tick);
    }
    /// The answers that are due: in lockstep one to every tick, when `complete`; in real time to the
    /// newest tick, incomplete at `deadline_ns` (0 = never), and again when there is `news`.
    Dues due(std::uint64_t tick, bool complete, bool news, std::uint64_t deadline_ns = 0) const {
        Dues dues{};
        dues.size = zeronav_due(context_, tick, complete, deadline_ns, news, dues.ticks);
        return dues;
    }
    /// Begins the answer to a tick that is due; throws `std::logic_error` when it is not.
    Begun begin(std::uint64_t tick, std::uint64_t capture_ns, const Parents& parents) const {
        Begun begun{};
        if (!zeronav_begin(context_, tick, capture_ns, &parents, &begun)) {
            throw std::logic_error("begin: no answer to this tick is due");
        }
        return begun;
    }
    /// Ends the answer: rings, and leaves its record with the `work` done.
    void finish(std::uint64_t work = 0) const { zeronav_finish(context_, work); }
    /// Sets or clears a reason in the heartbeat.
    void reason(int bit, bool holds) const {
        zeronav_reason(context_, static_cast<std::uint32_t>(bit), holds);
    }

    raw::Context* context() const { return context_; }

private:
    raw::Context* context_;
};

/// Thrown by a port that does not open; the shell knows why.
struct NotOpened : std::exception {
    const char* what() const noexcept override { return "a port did not open"; }
};

/// The number of a port that was opened.
inline std::size_t opened(std::int32_t number) {
    if (number < 0) {
        throw NotOpened{};
    }
    return static_cast<std::size_t>(number);
}

/// Keeps the newest message of a topic.
template <typename Topic>
class Latest {
public:
    explicit Latest(const Shell& shell) : number_(opened(zeronav_reader(shell.context(), Topic::NUMBER))) {}

    /// Takes in what has come; true when there is a newer message than before.
    bool poll(const Shell& shell) const { return zeronav_poll(shell.context(), number_); }
    /// Tick up to which the writer has answered, whether its message was accepted or rejected.
    std::uint64_t spoken_tick(const Shell& shell) const {
        return zeronav_spoken_tick(shell.context(), number_);
    }
    /// The newest message.
    View<Topic> get(const Shell& shell) const {
        raw::View found{};
        if (!zeronav_get(shell.context(), number_, &found)) {
            return {};
        }
        const auto* envelope = static_cast<const typename Topic::Envelope*>(found.envelope);
        const auto* items = static_cast<const typename Topic::Item*>(found.items);
        return {&envelope->header, &envelope->meta, items, found.len, found.came_ns};
    }

private:
    std::size_t number_;
};

/// The writing end of a topic.
template <typename Topic>
class Writer {
public:
    using Meta = decltype(Topic::Envelope::meta);

    /// With slices of up to `len` items.
    explicit Writer(const Shell& shell, std::size_t len = 1)
        : number_(opened(zeronav_writer(shell.context(), Topic::NUMBER, len))) {}

    /// Sends a message of the answer that was begun; the first is its main message. False when it was
    /// dropped.
    bool send(const Shell& shell, const Meta& meta, const typename Topic::Item* items = nullptr,
              std::size_t size = 0) const {
        return zeronav_send(shell.context(), number_, &meta, sizeof meta, items,
                            size * sizeof(typename Topic::Item));
    }
    /// Brings the last message of a latched topic to readers that joined since.
    void refresh(const Shell& shell) const { zeronav_refresh(shell.context(), number_); }

private:
    std::size_t number_;
};

/// `main` of a service in the seat `Service::ROLE`: flags, ports, loop, exit code. `Service` is made
/// from a `const Shell&`, where it opens its ports, and has `void wake(const Shell&, std::uint64_t
/// rung)`. An exception ends the process as a crash.
template <typename Service>
int run() {
    const auto open = [](raw::Context* context) -> void* {
        try {
            return new Service(Shell(context));
        } catch (const NotOpened&) {
        } catch (const std::exception& error) {
            zeronav_fail(context, error.what());
        } catch (...) {
            zeronav_fail(context, "unknown exception");
        }
        return nullptr;
    };
    const auto wake = [](void* service, raw::Context* context, std::uint64_t rung) {
        try {
            static_cast<Service*>(service)->wake(Shell(context), rung);
        } catch (const std::exception& error) {
            zeronav_fail(context, error.what());
        } catch (...) {
            zeronav_fail(context, "unknown exception");
        }
    };
    const auto close = [](void* service) { delete static_cast<Service*>(service); };
    return zeronav_run(static_cast<std::uint16_t>(Service::ROLE), {open, wake, close});
}

}  // namespace zeronav
