// A control loop at 1 kHz, in the form that robots' vendors give it: a callback that gets the robot's
// state and returns a command, every millisecond. It plans within the callback, a few units of work in
// each cycle, and prints how long that took.
//
//     control_loop [cycles]

#include <algorithm>
#include <array>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <time.h>

#include "nsrm.hpp"
#include "table.h"

namespace {

/// What the robot measures.
struct RobotState {
    std::array<double, 7> joint_positions;
};

/// What it is to do in the next millisecond.
struct Command {
    std::array<double, 7> joint_velocities{};
    bool finished = false;
};

/// In place of a vendor's robot: calls back every millisecond, by the clock.
class Robot {
  public:
    template <class Callback> void control(Callback &&callback) {
        timespec wake{};
        clock_gettime(CLOCK_MONOTONIC, &wake);
        Command command;
        while (!command.finished) {
            command = callback(state_);
            for (std::size_t joint = 0; joint < state_.joint_positions.size(); ++joint) {
                state_.joint_positions[joint] += 0.001 * command.joint_velocities[joint];
            }
            wake.tv_nsec += 1'000'000;
            if (wake.tv_nsec >= 1'000'000'000) {
                wake.tv_nsec -= 1'000'000'000;
                ++wake.tv_sec;
            }
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
        }
    }

  private:
    RobotState state_{};
};

/// Times in microseconds, counted by powers of two.
class Histogram {
  public:
    void add(std::chrono::nanoseconds took) {
        std::size_t place = 0;
        while (place + 1 < counts_.size() && took.count() >= (1'000LL << place)) {
            ++place;
        }
        ++counts_[place];
        longest_ = std::max(longest_, took);
    }

    void print() const {
        const unsigned most = *std::max_element(counts_.begin(), counts_.end());
        for (std::size_t place = 0; place < counts_.size(); ++place) {
            if (counts_[place] > 0) {
                const unsigned bar = (50 * counts_[place] + most - 1) / most;
                std::printf("  < %4u us %6u %.*s\n", 1U << place, counts_[place],
                            static_cast<int>(bar),
                            "##################################################");
            }
        }
        std::printf("  longest %.1f us\n", static_cast<double>(longest_.count()) / 1000.0);
    }

  private:
    std::array<unsigned, 12> counts_{};
    std::chrono::nanoseconds longest_{};
};

constexpr std::array<std::string_view, 3> SENTENCES{
    "put the small green block to the right of the red block",
    "put the blue block on the red block, then put the yellow block on the blue block",
    "put the crimson block on the blue block",
};

/// Units of work in a cycle: with 20, a sentence takes some ten cycles.
constexpr unsigned BUDGET = 20;

// Static, as a controller has them.
nsrm::Task task;
nsrm::Observer observer;
nsrm::Scene scene;
std::array<std::uint8_t, 3 * TABLE_WIDTH * TABLE_HEIGHT> pixels;

bool observe(nsrm::Model model) {
    std::array<nsrm::Detection, TABLE_BLOCKS> detections{};
    table_look(pixels.data(), detections.data());
    const nsrm_image_t image{pixels.data(), pixels.size(), TABLE_WIDTH, TABLE_HEIGHT,
                             std::size_t{3} * TABLE_WIDTH};
    const nsrm::Status status = observer.observe(
        model, image, TABLE_CAMERA, {detections.data(), detections.size()}, 1, 0, scene);
    if (status != NSRM_OK) {
        std::fprintf(stderr, "error: %s\n", observer.message().c_str());
    }
    return status == NSRM_OK;
}

} // namespace

int main(int count, char **arguments) {
    const long cycles = count > 1 ? std::strtol(arguments[1], nullptr, 10) : 2'000;
    const auto model = nsrm::Model::tabletop();
    if (!observe(model)) {
        return 1;
    }

    Robot robot;
    Histogram histogram;
    long cycle = 0;
    std::array<unsigned, 2> planned_refused{};
    std::size_t next = 0;
    task.begin(model, scene, SENTENCES[next]);
    robot.control([&](const RobotState &) {
        const auto start = std::chrono::steady_clock::now();
        const nsrm::Status status = task.poll(BUDGET);
        if (status != NSRM_PENDING) {
            // A robot would pass the sub-goals to its motion planner here.
            ++planned_refused[task.plan() ? 0 : 1];
            next = (next + 1) % SENTENCES.size();
            task.begin(model, scene, SENTENCES[next]);
        }
        histogram.add(std::chrono::steady_clock::now() - start);
        Command command;
        command.finished = ++cycle >= cycles;
        return command;
    });
    std::printf("%ld cycles of 1 ms: %u sentences planned, %u refused; planning took, by cycle:\n",
                cycles, planned_refused[0], planned_refused[1]);
    histogram.print();
    return planned_refused[0] > 0 && planned_refused[1] > 0 ? 0 : 1;
}
