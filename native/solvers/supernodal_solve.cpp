// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/supernodal_solve.h"

#include "native/core/parallel.h"
#include "native/solvers/lanes.h"

#include <algorithm>
#include <mutex>
#include <numeric>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr int block_width = 16;
constexpr int most_subtrees = 16;
constexpr double least_parallel = 1.5e5; ///< factor entries; below, one thread is faster

constexpr int fetched_ahead = 2048; ///< factor entries

} // namespace

template <class T>
struct SupernodalSolve<T>::Impl
{
    /// Supernodes [begin, end) with everything below them: columns [first_column, last_column).
    struct Subtree
    {
        int begin, end;
        int first_column, last_column;
    };

    /// Reused by later solves; several at once each take their own.
    struct Workspace
    {
        std::vector<T> points;            ///< (n) lanes in elimination order, for solve()
        std::vector<std::vector<T>> sums; ///< one a subtree: lanes of the unknowns above all subtrees
        std::vector<std::vector<T>>
            rows; ///< one a subtree, the last for the top: lanes of one supernode's rows
    };

    explicit Impl(const BasicSupernodalFactor<T>& factor) : f(factor), kernels(lane_kernels<T>())
    {
        invert_diagonal_blocks({});
        choose_subtrees();
    }

    int columns(int s) const { return f.columns(s); }
    int height(int s) const { return f.height(s); }
    T* block(int s) const { return f.block(s); }

    /// Of the chosen supernodes; of all where none are named.
    void invert_diagonal_blocks(const std::vector<char>& chosen)
    {
        reciprocals.resize(f.size);
        parallel_chunks(f.supernodes, 256, [&](int begin, int end) {
            for (int s = begin; s < end; ++s) {
                if (!chosen.empty() && !chosen[s])
                    continue;
                const int stride = height(s);
                for (int c = 0; c < columns(s); c += block_width)
                    invert(block(s) + c * (stride + 1), stride, std::min(block_width, columns(s) - c),
                           reciprocals.data() + f.first[s] + c);
            }
        });
    }

    /// The inverse of a lower triangle: its diagonal, and transposed above L's diagonal its strict part.
    static void invert(T* L, int stride, int width, T* diagonal)
    {
        for (int i = 0; i < width; ++i) {
            diagonal[i] = 1.0 / L[i * (stride + 1)];
            for (int j = 0; j < i; ++j) {
                T sum = L[i + j * stride] * diagonal[j];
                for (int k = j + 1; k < i; ++k)
                    sum += L[i + k * stride] * L[j + k * stride];
                L[j + i * stride] = -diagonal[i] * sum;
            }
        }
    }

    /// Parts of the tree of equal weight; what is left on top is done alone.
    void choose_subtrees()
    {
        std::vector<double> entries(f.supernodes);
        for (int s = 0; s < f.supernodes; ++s)
            entries[s] = static_cast<double>(columns(s)) * height(s);
        on_top.assign(f.supernodes, false);
        if (std::accumulate(entries.begin(), entries.end(), 0.0) < least_parallel)
            return;
        SupernodalSplit cut = split(SupernodalTree(f), std::move(entries), most_subtrees);
        for (const auto [begin, end] : cut.parts)
            subtrees.push_back({begin, end, f.first[begin], f.first[end]});
        on_top = std::move(cut.on_top);
        top_position.assign(f.size, -1);
        for (int s = 0; s < f.supernodes; ++s)
            if (on_top[s])
                for (int c = f.first[s]; c < f.first[s + 1]; ++c)
                    top_position[c] = top_count++;
    }

    /// Small blocks are too short for the processor to see where the reading goes: fetch what comes after
    /// (or before) the block of s, some kilobytes ahead.
    void fetch(int s, std::ptrdiff_t ahead) const
    {
#ifdef __GNUC__
        constexpr int line = 64 / sizeof(T);
        const T* const end = f.values + f.block_begin[s + 1] + ahead;
        for (const T* at = f.values + f.block_begin[s] + ahead; at < end; at += line)
            __builtin_prefetch(at);
#endif
    }

    /// x = L^-1 x for one supernode's own columns; returns -L21 x for the rows below, in `below`.
    void forward(int s, T* points, T* below) const
    {
        const int width = columns(s), stride = height(s), rest = stride - width;
        T* own = points + lane_count * static_cast<std::size_t>(f.first[s]);
        fetch(s, fetched_ahead);
        std::fill_n(below, lane_count * rest, 0.0);
        for (int c = 0; c < width; c += block_width) {
            const int part = std::min(block_width, width - c);
            const T* L = block(s) + static_cast<std::size_t>(c) * stride;
            kernels.triangle(L + c, stride, part, reciprocals.data() + f.first[s] + c, own + lane_count * c);
            kernels.subtract_product(L + c + part, stride, part, width - c - part, own + lane_count * c,
                                     own + lane_count * (c + part));
            kernels.subtract_product(L + width, stride, part, rest, own + lane_count * c, below);
        }
    }

    /// x = L^-T x for one supernode's own columns, given the rows below.
    void backward(int s, T* points, const T* below) const
    {
        const int width = columns(s), stride = height(s), rest = stride - width;
        T* own = points + lane_count * static_cast<std::size_t>(f.first[s]);
        for (int c = (width - 1) / block_width * block_width; c >= 0; c -= block_width) {
            const int part = std::min(block_width, width - c);
            const T* L = block(s) + static_cast<std::size_t>(c) * stride;
            kernels.subtract_transposed(L + c + part, stride, part, width - c - part,
                                        own + lane_count * (c + part), own + lane_count * c);
            kernels.subtract_transposed(L + width, stride, part, rest, below, own + lane_count * c);
            kernels.triangle_transposed(L + c, stride, part, reciprocals.data() + f.first[s] + c,
                                        own + lane_count * c);
        }
    }

    static void add(T* to, const T* from)
    {
        for (int k = 0; k < lane_count; ++k)
            to[k] += from[k];
    }

    static void copy(T* to, const T* from) { std::copy_n(from, lane_count, to); }

    void forward_subtree(const Subtree& subtree, T* points, T* sums, T* below) const
    {
        for (int s = subtree.begin; s < subtree.end; ++s) {
            forward(s, points, below);
            const int* rows = f.rows + f.row_begin[s] + columns(s);
            const int rest = height(s) - columns(s);
            int r = 0;
            for (; r < rest && rows[r] < subtree.last_column; ++r)
                add(points + lane_count * static_cast<std::size_t>(rows[r]), below + lane_count * r);
            for (; r < rest; ++r)
                add(sums + lane_count * static_cast<std::size_t>(top_position[rows[r]]),
                    below + lane_count * r);
        }
    }

    void forward_alone(int s, T* points, T* below) const
    {
        forward(s, points, below);
        const int* rows = f.rows + f.row_begin[s] + columns(s);
        for (int r = 0; r < height(s) - columns(s); ++r)
            add(points + lane_count * static_cast<std::size_t>(rows[r]), below + lane_count * r);
    }

    void backward_alone(int s, T* points, T* below) const
    {
        const int* rows = f.rows + f.row_begin[s] + columns(s);
        fetch(s, -fetched_ahead);
        for (int r = 0; r < height(s) - columns(s); ++r)
            copy(below + lane_count * r, points + lane_count * static_cast<std::size_t>(rows[r]));
        backward(s, points, below);
    }

    void sweep(T* points, Workspace& work) const
    {
        T* top_rows = work.rows.back().data();
        const int tasks = static_cast<int>(subtrees.size());
        if (tasks == 0) {
            for (int s = 0; s < f.supernodes; ++s)
                forward_alone(s, points, top_rows);
            for (int s = f.supernodes - 1; s >= 0; --s)
                backward_alone(s, points, top_rows);
            return;
        }
        parallel_tasks(tasks, [&](int t) {
            std::fill(work.sums[t].begin(), work.sums[t].end(), 0.0);
            forward_subtree(subtrees[t], points, work.sums[t].data(), work.rows[t].data());
        });
        for (int s = 0; s < f.supernodes; ++s)
            if (on_top[s])
                for (int c = f.first[s]; c < f.first[s + 1]; ++c)
                    for (int t = 0; t < tasks; ++t)
                        add(points + lane_count * static_cast<std::size_t>(c),
                            work.sums[t].data() + lane_count * static_cast<std::size_t>(top_position[c]));
        for (int s = 0; s < f.supernodes; ++s)
            if (on_top[s])
                forward_alone(s, points, top_rows);
        for (int s = f.supernodes - 1; s >= 0; --s)
            if (on_top[s])
                backward_alone(s, points, top_rows);
        parallel_tasks(tasks, [&](int t) {
            for (int s = subtrees[t].end - 1; s >= subtrees[t].begin; --s)
                backward_alone(s, points, work.rows[t].data());
        });
    }

    std::unique_ptr<Workspace> take() const
    {
        {
            const std::lock_guard lock(mutex);
            if (!idle.empty()) {
                std::unique_ptr<Workspace> work = std::move(idle.back());
                idle.pop_back();
                return work;
            }
        }
        auto work = std::make_unique<Workspace>();
        int tallest = 0;
        for (int s = 0; s < f.supernodes; ++s)
            tallest = std::max(tallest, height(s) - columns(s));
        work->sums.assign(subtrees.size(), std::vector<T>(static_cast<std::size_t>(top_count) * lane_count));
        work->rows.assign(subtrees.size() + 1,
                          std::vector<T>(static_cast<std::size_t>(tallest) * lane_count));
        return work;
    }

    void give_back(std::unique_ptr<Workspace> work) const
    {
        const std::lock_guard lock(mutex);
        idle.push_back(std::move(work));
    }

    template <class Fill, class Read>
    void run(Fill&& fill, Read&& read) const
    {
        std::unique_ptr<Workspace> work = take();
        work->points.resize(static_cast<std::size_t>(f.size) * lane_count);
        T* points = work->points.data();
        fill(points);
        sweep(points, *work);
        read(points);
        give_back(std::move(work));
    }

    /// body(unknown, lanes) for each point.
    template <class Body>
    void each(T* points, const Body& body) const
    {
        constexpr int grain = 16384;
        parallel_for(
            f.size, [&](int i) { body(f.permutation[i], points + lane_count * static_cast<std::size_t>(i)); },
            grain);
    }

    BasicSupernodalFactor<T> f;
    const LaneKernels<T>& kernels;
    std::vector<T> reciprocals; ///< of the diagonal
    std::vector<Subtree> subtrees;
    std::vector<char> on_top;
    std::vector<int> top_position; ///< of each column on top among all such, else -1
    int top_count = 0;
    mutable std::mutex mutex;
    mutable std::vector<std::unique_ptr<Workspace>> idle;
};

template <class T>
SupernodalSolve<T>::SupernodalSolve(const BasicSupernodalFactor<T>& factor)
    : impl_(std::make_unique<Impl>(factor))
{
}
template <class T>
SupernodalSolve<T>::~SupernodalSolve() = default;

template <class T>
void SupernodalSolve<T>::renew(const std::vector<char>& chosen)
{
    impl_->invert_diagonal_blocks(chosen);
}

template <class T>
void SupernodalSolve<T>::solve(const MatrixX& rhs, MatrixX& solution) const
{
    const int k = static_cast<int>(rhs.cols());
    solution.resize(rhs.rows(), k);
    impl_->run(
        [&](T* points) {
            impl_->each(points, [&](int unknown, T* point) {
                for (int c = 0; c < lane_count; ++c)
                    point[c] = c < k ? static_cast<T>(rhs(unknown, c)) : T(0);
            });
        },
        [&](T* points) {
            impl_->each(points, [&](int unknown, const T* point) {
                for (int c = 0; c < k; ++c)
                    solution(unknown, c) = point[c];
            });
        });
}

template <class T>
void SupernodalSolve<T>::solve_rows(RowMatrix& x, int first, int k) const
{
    impl_->run(
        [&](T* points) {
            impl_->each(points, [&](int unknown, T* point) {
                for (int c = 0; c < lane_count; ++c)
                    point[c] = c < k ? static_cast<T>(x(unknown, first + c)) : T(0);
            });
        },
        [&](T* points) {
            impl_->each(points, [&](int unknown, const T* point) {
                for (int c = 0; c < k; ++c)
                    x(unknown, first + c) = point[c];
            });
        });
}

template <class T>
void SupernodalSolve<T>::sweep(const std::function<void(T*)>& fill,
                               const std::function<void(const T*)>& read) const
{
    impl_->run(fill, read);
}

template class SupernodalSolve<double>;
template class SupernodalSolve<float>;

} // namespace sinew
