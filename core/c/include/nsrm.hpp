/* The C++ interface of NSRM, over nsrm.h: C++17, header only, without exceptions and allocation.
 *
 *     nsrm::Task task;                       // 14 KB: as a member or static, not on a small stack
 *     auto plan = task.plan(nsrm::Model::tabletop(), scene, "put the red block on the blue block");
 *     if (plan) {
 *         for (const nsrm::SubGoal &goal : nsrm::sub_goals(*plan)) { ... }
 *     } else {
 *         log(task.message().view());        // why it is refused, in full sentences
 *     }
 *
 * SPDX-License-Identifier: Apache-2.0 */

#ifndef NSRM_HPP
#define NSRM_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#if __has_include(<version>)
#include <version>
#endif
#if defined(__cpp_lib_span)
#include <span>
#endif

#include "nsrm.h"

namespace nsrm {

using Camera = nsrm_camera_t;
using Correction = nsrm_correction_t;
using Detection = nsrm_detection_t;
using Info = nsrm_model_info_t;
using Plan = nsrm_plan_t;
using Program = nsrm_program_t;
using ProgramStep = nsrm_program_step_t;
using Refusal = nsrm_refusal_t;
using RefusalKind = nsrm_refusal_kind_t;
using Scene = nsrm_scene_t;
using Status = nsrm_status_t;
using SubGoal = nsrm_sub_goal_t;

#if defined(__cpp_lib_span)
template <class T> using Span = std::span<T>;
#else
/** Elements one behind the other, as std::span<T> of C++20. */
template <class T> class Span {
  public:
    constexpr Span() noexcept = default;
    constexpr Span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}

    constexpr T *data() const noexcept { return data_; }
    constexpr std::size_t size() const noexcept { return size_; }
    constexpr bool empty() const noexcept { return size_ == 0; }
    constexpr T *begin() const noexcept { return data_; }
    constexpr T *end() const noexcept { return data_ + size_; }
    constexpr T &operator[](std::size_t index) const noexcept { return data_[index]; }

  private:
    T *data_ = nullptr;
    std::size_t size_ = 0;
};
#endif

/** The text of a `nsrm_text_t`. */
inline std::string_view view(const nsrm_text_t &text) noexcept {
    return text.data == nullptr ? std::string_view{} : std::string_view{text.data, text.length};
}

/** The meaning of a status. */
inline std::string_view text(Status status) noexcept {
    return nsrm_status_text(static_cast<int32_t>(status));
}

/** The sub-goals of a plan, in the order of execution. */
inline Span<const SubGoal> sub_goals(const Plan &plan) noexcept {
    return {static_cast<const SubGoal *>(plan.sub_goals), plan.count};
}

/** The steps of a program, in the order of execution. */
inline Span<const ProgramStep> steps(const Program &program) noexcept {
    return {static_cast<const ProgramStep *>(program.steps), program.step_count};
}

/** The misspelt words of a program's sentence: tell the person. */
inline Span<const Correction> corrections(const Program &program) noexcept {
    return {static_cast<const Correction *>(program.corrections), program.correction_count};
}

/** A value, or why there is none. */
template <class T> class Result {
  public:
    Result(Status status) noexcept : status_(status) {}
    Result(const T &value) noexcept : status_(NSRM_OK), value_(value) {}

    /** Whether there is a value. */
    explicit operator bool() const noexcept { return value_.has_value(); }
    Status status() const noexcept { return status_; }

    /** The value; undefined without one. */
    const T &operator*() const noexcept { return *value_; }
    const T *operator->() const noexcept { return &*value_; }

  private:
    Status status_;
    std::optional<T> value_;
};

/** Text for a person, cut if it is longer than `Size` bytes. */
template <std::size_t Size> class Message {
  public:
    std::string_view view() const noexcept { return {bytes_.data()}; }
    const char *c_str() const noexcept { return bytes_.data(); }

    /** Filled by a function of nsrm.h; empty if that fails. */
    template <class Write> static Message filled(Write &&write) noexcept {
        Message message;
        const Status status = write(message.bytes_.data(), message.bytes_.size());
        if (status != NSRM_OK && status != NSRM_TRUNCATED) {
            message.bytes_[0] = '\0';
        }
        return message;
    }

  private:
    std::array<char, Size> bytes_{};
};

/** A trained model, by reference. */
class Model {
  public:
    /** The built-in model: toy blocks on a table. */
    static Model tabletop() noexcept { return Model{nsrm_tabletop()}; }
    /** The same with weights of eight bits, in a library that has them. */
    static Model tabletop_int8() noexcept { return Model{nsrm_tabletop_int8()}; }
    explicit constexpr Model(const nsrm_model_t *model) noexcept : model_(model) {}

    const nsrm_model_t *get() const noexcept { return model_; }
    Status check() const noexcept { return nsrm_model_check(model_); }

    Result<Info> info() const noexcept {
        Info info{};
        info.size = sizeof info;
        const Status status = nsrm_model_info(model_, &info);
        return status == NSRM_OK ? Result<Info>{info} : Result<Info>{status};
    }

    /** The name of an action; empty if there is none with this index. */
    std::string_view action(std::uint32_t index) const noexcept {
        nsrm_text_t name{};
        return nsrm_action_name(model_, index, &name) == NSRM_OK ? view(name) : std::string_view{};
    }

    /** The name of an attribute value; empty if there is none with this index. */
    std::string_view concept_name(std::uint32_t index) const noexcept {
        nsrm_text_t name{};
        return nsrm_concept_name(model_, index, &name) == NSRM_OK ? view(name) : std::string_view{};
    }

    /** The name of what is counted, "second leftmost"; empty if there is none with this index. */
    std::string_view ranked(std::uint32_t index) const noexcept {
        nsrm_text_t name{};
        return nsrm_ranked_name(model_, index, &name) == NSRM_OK ? view(name) : std::string_view{};
    }

  private:
    const nsrm_model_t *model_;
};

/** Plans and parses. Has all memory that this takes, and stays where it is; scene and sentence must
 *  outlive what is begun with them. */
class Task {
  public:
    Task() noexcept = default;
    Task(const Task &) = delete;
    Task &operator=(const Task &) = delete;

    /** Begins a plan; `poll` does the work. */
    Status begin(Model model, const Scene &scene, std::string_view sentence) noexcept {
        return nsrm_begin(&task_, model.get(), &scene, sentence.data(), sentence.size());
    }

    /** Begins to parse a sentence without a scene. */
    Status begin_parsing(Model model, std::string_view sentence) noexcept {
        return nsrm_begin_parsing(&task_, model.get(), sentence.data(), sentence.size());
    }

    /** Begins to ground the program in a scene as it is now, from a step on. */
    Status begin_grounding(const Scene &scene, std::uint32_t first) noexcept {
        return nsrm_begin_grounding(&task_, &scene, first);
    }

    /** One bounded unit of work: NSRM_PENDING until it is done. */
    Status poll() noexcept { return nsrm_poll(&task_); }

    /** At most `units` of them. */
    Status poll(unsigned units) noexcept {
        Status status = NSRM_PENDING;
        while (units-- > 0 && status == NSRM_PENDING) {
            status = nsrm_poll(&task_);
        }
        return status;
    }

    /** Begins and polls to the end. */
    Result<Plan> plan(Model model, const Scene &scene, std::string_view sentence) noexcept {
        return sized<Plan>([&](Plan *plan) {
            return nsrm_plan(&task_, model.get(), &scene, sentence.data(), sentence.size(), plan);
        });
    }

    /** Begins and polls to the end, without a scene. */
    Result<Program> parse(Model model, std::string_view sentence) noexcept {
        return sized<Program>([&](Program *program) {
            return nsrm_parse(&task_, model.get(), sentence.data(), sentence.size(), program);
        });
    }

    /** Whether a scene agrees with the camera's calibration. */
    Status check(Model model, const Scene &scene) noexcept {
        return nsrm_check(&task_, model.get(), &scene);
    }

    /** What came of it, once `poll` no longer returns NSRM_PENDING. */
    Result<Plan> plan() noexcept {
        return sized<Plan>([&](Plan *plan) { return nsrm_get_plan(&task_, plan); });
    }
    Result<Program> program() noexcept {
        return sized<Program>([&](Program *program) { return nsrm_get_program(&task_, program); });
    }
    Result<Refusal> refusal() noexcept {
        return sized<Refusal>([&](Refusal *refusal) { return nsrm_get_refusal(&task_, refusal); });
    }

    /** Why there is no result, in full sentences. */
    template <std::size_t Size = 512> Message<Size> message() noexcept {
        return Message<Size>::filled([&](char *buffer, std::size_t size) {
            return nsrm_refusal_message(&task_, buffer, size, nullptr);
        });
    }

    /** The program in the paper's notation. */
    template <std::size_t Size = 1024> Message<Size> notation() noexcept {
        return Message<Size>::filled([&](char *buffer, std::size_t size) {
            return nsrm_program_notation(&task_, buffer, size, nullptr);
        });
    }

    /** What the plan does and why. */
    template <std::size_t Size = 2048> Message<Size> explanation() noexcept {
        return Message<Size>::filled([&](char *buffer, std::size_t size) {
            return nsrm_plan_explanation(&task_, buffer, size, nullptr);
        });
    }

  private:
    template <class T, class Call> static Result<T> sized(Call &&call) noexcept {
        T value{};
        value.size = sizeof value;
        const Status status = call(&value);
        return status == NSRM_OK ? Result<T>{value} : Result<T>{status};
    }

    nsrm_task_t task_{};
};

/** Makes scenes from images. Has all memory that this takes, and stays where it is. */
class Observer {
  public:
    Observer() noexcept = default;
    Observer(const Observer &) = delete;
    Observer &operator=(const Observer &) = delete;

    /** Begins a scene; `poll` does the work. Pixels and detections must outlive it. */
    Status begin(Model model, const nsrm_image_t &image, const Camera &camera,
                 Span<const Detection> detections, std::uint64_t sequence,
                 std::uint64_t timestamp_ns) noexcept {
        return nsrm_observe_begin(&observer_, model.get(), &image, &camera, detections.data(),
                                  detections.size(), sequence, timestamp_ns);
    }

    /** Encodes one object: NSRM_PENDING until it is done; with NSRM_OK the scene is written. */
    Status poll(Scene &scene) noexcept { return nsrm_observe_poll(&observer_, &scene); }

    /** Begins and polls to the end. */
    Status observe(Model model, const nsrm_image_t &image, const Camera &camera,
                   Span<const Detection> detections, std::uint64_t sequence,
                   std::uint64_t timestamp_ns, Scene &scene) noexcept {
        return nsrm_observe(&observer_, model.get(), &image, &camera, detections.data(),
                            detections.size(), sequence, timestamp_ns, &scene);
    }

    /** Why there is no scene. */
    template <std::size_t Size = 512> Message<Size> message() noexcept {
        return Message<Size>::filled([&](char *buffer, std::size_t size) {
            return nsrm_observer_message(&observer_, buffer, size, nullptr);
        });
    }

  private:
    nsrm_observer_t observer_{};
};

} // namespace nsrm

#endif /* NSRM_HPP */
