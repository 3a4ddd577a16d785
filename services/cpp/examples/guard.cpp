// A guard in C++: passes on what is asked, within the robot's acceleration, and slows down so that the
// robot stops before whatever the scan shows straight ahead of it. Turning is not checked.
#include "zeronav_service.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

using namespace zeronav;

/// How long after odometry the request that belongs to it is awaited. [ns]
constexpr std::uint64_t PATIENCE_NS = 5'000'000;
/// Age at which a request, a scan or odometry counts as lost. [ns]
constexpr std::uint64_t REQUEST_AGE_NS = 100'000'000;
constexpr std::uint64_t SCAN_AGE_NS = 350'000'000;
constexpr std::uint64_t ODOMETRY_AGE_NS = 100'000'000;
/// Distance that is kept to what lies in the way. [m]
constexpr double MARGIN_M = 0.1;

class Guard {
public:
    static constexpr Role ROLE = Role::collision_guard;

    explicit Guard(const Shell& shell)
        : robot_(shell), scan_(shell), request_(shell), command_(shell) {}

    void wake(const Shell& shell, std::uint64_t) {
        robot_.poll(shell);
        const bool requested = request_.poll(shell);
        scan_.poll(shell);
        const auto odometry = shell.odometry();
        const bool complete = shell.run().lockstep
            ? !shell.awaits(Role::local_planner, odometry.tick, request_.spoken_tick(shell))
            : requested;
        for (const auto tick : shell.due(odometry.tick, complete, requested, odometry.came_ns + PATIENCE_NS)) {
            answer(shell, tick, odometry);
        }
    }

private:
    void answer(const Shell& shell, std::uint64_t tick, const NewestOdometry& odometry) {
        const auto scan = scan_.get(shell);
        const auto request = request_.get(shell);
        Parents parents;
        parents.odometry = odometry.id;
        parents.scan = scan.id();
        parents.request = request.id();
        if (!has_begun_ && odometry.id != 0) {
            // The robot may move already when a successor begins.
            has_begun_ = true;
            v_mps_ = odometry.odometry.v_mps;
            w_radps_ = odometry.odometry.w_radps;
        }
        const auto begun = shell.begin(tick, scan ? scan.header->capture_ns : 0, parents);
        const auto elapsed_s = 1e-9 * static_cast<double>(elapsed_ns(shell, begun, odometry));
        const auto command = decide(shell, begun, odometry, elapsed_s);
        command_.send(shell, command);
        shell.finish();
        v_mps_ = command.v_mps;
        w_radps_ = command.w_radps;
        for (const auto& [stale, reason] : {std::pair{Intervention::request_stale, REASON_REQUEST},
                                            std::pair{Intervention::scan_stale, REASON_SCAN},
                                            std::pair{Intervention::odometry_stale, REASON_ODOMETRY},
                                            std::pair{Intervention::zones_missing, REASON_ZONES}}) {
            shell.reason(reason, command.intervention == code(stale));
        }
    }

    /// Time since the answer before: from tick to tick, one tick for the first answer of a successor.
    /// While odometry is late the ticks stand still, and the robot has to come to rest all the same.
    std::uint64_t elapsed_ns(const Shell& shell, const Begun& begun, const NewestOdometry& odometry) {
        const auto run = shell.run();
        const auto ticks = begun.tick > run.answered_tick ? begun.tick - run.answered_tick : 0;
        const auto before_ns = std::exchange(answered_ns_, begun.started_ns);
        const bool is_late = odometry.id != 0 && begun.started_ns > odometry.came_ns + run.tick_ns;
        if (ticks == 0 && is_late && !run.lockstep) {
            return begun.started_ns - before_ns;
        }
        return run.tick_ns * (run.answered_tick == 0 ? std::min<std::uint64_t>(ticks, 1) : ticks);
    }

    VelocityCommand decide(const Shell& shell, const Begun& begun, const NewestOdometry& odometry, double elapsed_s) {
        const auto robot = robot_.get(shell);
        const auto scan = scan_.get(shell);
        const auto request = request_.get(shell);
        const auto run = shell.run();
        const auto is_old = [&](std::uint64_t run_ns, std::uint64_t came_ns, std::uint64_t most_ns) {
            const auto now_ns = run.lockstep ? begun.run_ns : begun.started_ns;
            const auto then_ns = run.lockstep ? run_ns : came_ns;
            return now_ns > then_ns && now_ns - then_ns > most_ns;
        };
        double v_mps = 0;
        double w_radps = 0;
        auto validity = Validity::stale;
        auto intervention = Intervention::none;
        if (run.stopping) {
            validity = Validity::stopped;
        } else if (begun.tick == 0 || !robot || odometry.id == 0 || !request) {
            validity = Validity::no_request;
        } else if (run.zones) {
            // It does not know how to keep out of them.
            intervention = Intervention::zones_missing;
        } else if (is_old(request.header->run_ns, request.came_ns, REQUEST_AGE_NS)) {
            intervention = Intervention::request_stale;
        } else if (!scan || is_old(scan.header->run_ns, scan.came_ns, SCAN_AGE_NS)) {
            intervention = Intervention::scan_stale;
        } else if (is_old(odometry.run_ns, odometry.came_ns, ODOMETRY_AGE_NS)) {
            intervention = Intervention::odometry_stale;
        } else {
            validity = static_cast<Validity>(request.meta->validity);
        }
        if (!robot) {
            return {0, 0, code(validity), code(intervention)};
        }
        if (validity == Validity::drive) {
            v_mps = request.meta->v_mps;
            w_radps = request.meta->w_radps;
            const double room_m = std::max(0.0, free_m(*robot.meta, scan, v_mps) - MARGIN_M);
            const double limit_mps = std::sqrt(2 * robot.meta->brake_mps2 * room_m);
            if (std::abs(v_mps) > limit_mps) {
                v_mps = std::copysign(limit_mps, v_mps);
                intervention = limit_mps > 0 ? Intervention::slowed : Intervention::stopped_short;
            }
        }
        limit(*robot.meta, elapsed_s, v_mps, w_radps, intervention);
        return {v_mps, w_radps, code(validity), code(intervention)};
    }

    /// Brings speeds within the robot's limits, and within what it can change in `elapsed_s`.
    void limit(const Description& robot, double elapsed_s, double& v_mps, double& w_radps,
               Intervention& intervention) const {
        const double dv_mps = elapsed_s * (std::abs(v_mps) < std::abs(v_mps_) ? robot.brake_mps2 : robot.a_mps2_max);
        const double dw_radps = elapsed_s * robot.alpha_radps2_max;
        const double v = std::clamp(std::clamp(v_mps, v_mps_ - dv_mps, v_mps_ + dv_mps), robot.v_mps_min, robot.v_mps_max);
        const double w = std::clamp(std::clamp(w_radps, w_radps_ - dw_radps, w_radps_ + dw_radps), -robot.w_radps_max, robot.w_radps_max);
        if ((v != v_mps || w != w_radps) && intervention == Intervention::none) {
            intervention = Intervention::clamped;
        }
        v_mps = v;
        w_radps = w;
    }

    /// Distance that the robot can go straight in the direction of `v_mps`. [m]
    static double free_m(const Description& robot, const View<topics::robot_scan>& scan, double v_mps) {
        double nearest_m = std::numeric_limits<double>::infinity();
        const auto& laser = robot.base_from_laser;
        double angle = scan.meta->angle_min_rad + laser.yaw_rad;
        for (const float range_m : scan) {
            if (range_m >= scan.meta->range_m_min && range_m <= scan.meta->range_m_max) {
                const double x = (laser.x_m + range_m * std::cos(angle)) * (v_mps < 0 ? -1 : 1);
                const double y = laser.y_m + range_m * std::sin(angle);
                if (x > 0 && std::abs(y) < robot.inscribed_radius_m) {
                    nearest_m = std::min(nearest_m, x);
                }
            }
            angle += scan.meta->angle_increment_rad;
        }
        return nearest_m - robot.circumscribed_radius_m;
    }

    template <typename Code>
    static std::uint16_t code(Code value) {
        return static_cast<std::uint16_t>(value);
    }

    Latest<topics::robot_description> robot_;
    Latest<topics::robot_scan> scan_;
    Latest<topics::control_velocity_request> request_;
    Writer<topics::robot_velocity_command> command_;
    double v_mps_ = 0;
    double w_radps_ = 0;
    /// True once the speeds before are known.
    bool has_begun_ = false;
    /// When the answer before began.
    std::uint64_t answered_ns_ = 0;
};

int main() {
    return run<Guard>();
}
