// OMPL's control planners and FCL on two problems, with equations of motion written by hand.
//
//     baseline <disk|crane> <RRT|SST|KPIECE1|EST|PDST> <seed> <limit in s of CPU> [nodes ...]
//     baseline version
//
// Prints one line of JSON: when the first motion came into the goal, and its inputs. States are one
// real vector, each entry times its weight, which is OMPL's fastest setting. With numbers of nodes,
// nothing is in the goal: it prints what had been spent when the tree had so many, and stops at the
// last. With "effort" for a planner's name prefix (effort:SST) it searches until the limit for what
// costs least: the integral of the inputs' squares, and so much a second; states have that as a
// seventh entry, which no distance counts.

#include <ompl/base/PlannerData.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/goals/GoalSampleableRegion.h>
#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/control/PathControl.h>
#include <ompl/control/SpaceInformation.h>
#include <ompl/control/planners/est/EST.h>
#include <ompl/control/planners/kpiece/KPIECE1.h>
#include <ompl/control/planners/pdst/PDST.h>
#include <ompl/control/planners/rrt/RRT.h>
#include <ompl/control/planners/sst/SST.h>
#include <ompl/control/spaces/RealVectorControlSpace.h>
#include <ompl/util/RandomNumbers.h>

#include <fcl/config.h>
#include <fcl/fcl.h>
#include <ompl/config.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "problem.h"

namespace ob = ompl::base;
namespace oc = ompl::control;

static double seconds(clockid_t clock) {
    timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}
static double wall() { return seconds(CLOCK_MONOTONIC); }
static double cpu() { return seconds(CLOCK_PROCESS_CPUTIME_ID); }

static double resident_mb() {  // what is in use of memory
    long all = 0, resident = 0;
    if (FILE *file = fopen("/proc/self/statm", "r")) {
        if (fscanf(file, "%ld %ld", &all, &resident) != 2) resident = 0;
        fclose(file);
    }
    return 1e-6 * resident * sysconf(_SC_PAGESIZE);
}

static inline double short_way(double a) { return a - 2 * M_PI * floor((a + M_PI) / (2 * M_PI)); }

// ---- the machines ---------------------------------------------------------------------------

struct Disk {  // x, y, psi, phi, psi_dot, phi_dot
    static constexpr const double *weight = P_DISK_WEIGHT, *start = P_DISK_START;
    static constexpr const double *input = P_DISK_INPUT;
    static constexpr double goal_radius = P_DISK_GOAL_RADIUS;

    static void limits(double *lower, double *upper) {
        for (int i = 0; i < 2; ++i) {
            lower[i] = P_DISK_LOWER[i], upper[i] = P_DISK_UPPER[i];
            lower[2 + i] = -M_PI, upper[2 + i] = M_PI;
            lower[4 + i] = P_DISK_LOWER[2 + i], upper[4 + i] = P_DISK_UPPER[2 + i];
        }
    }
    static inline void f(const double *s, const double *u, double *d) {
        double v = P_DISK_RADIUS * s[5];
        d[0] = v * cos(s[2]);
        d[1] = v * sin(s[2]);
        d[2] = s[4];
        d[3] = s[5];
        d[4] = u[1] / P_DISK_TURN_INERTIA;
        d[5] = u[0] / (P_DISK_ROLL_INERTIA + P_DISK_MASS * P_DISK_RADIUS * P_DISK_RADIUS);
    }
    static inline void go_round(double *s) { s[2] = short_way(s[2]), s[3] = short_way(s[3]); }
    static inline double from_goal(const double *s) {
        return std::hypot(s[0] - P_DISK_GOAL[0], s[1] - P_DISK_GOAL[1]);
    }
    static void in_goal(ompl::RNG &random, double *s) {
        double lower[6], upper[6];
        limits(lower, upper);
        s[0] = P_DISK_GOAL[0], s[1] = P_DISK_GOAL[1], s[3] = 0;
        for (int i : {2, 4, 5}) s[i] = random.uniformReal(lower[i], upper[i]);
    }
    static std::shared_ptr<fcl::CollisionGeometryd> body() {
        return std::make_shared<fcl::Cylinderd>(P_DISK_RADIUS, P_DISK_THICKNESS);
    }
    static inline void place(const double *s, fcl::Matrix3d &R, fcl::Vector3d &p) {
        double c = cos(s[2]), n = sin(s[2]);
        R << c, 0, -n, n, 0, c, 0, -1, 0;
        p << s[0], s[1], P_DISK_RADIUS;
    }
    static inline double as_kinolab(const double *u, int i) { return u[i]; }
    static constexpr auto &boxes = P_DISK_BOXES;
};

struct Crane {  // x, l, theta, x_dot, l_dot, theta_dot
    static constexpr const double *weight = P_CRANE_WEIGHT, *start = P_CRANE_START;
    static constexpr const double *input = P_CRANE_INPUT;
    static constexpr double goal_radius = P_CRANE_GOAL_RADIUS;

    static void limits(double *lower, double *upper) {
        std::copy_n(P_CRANE_LOWER, 6, lower);
        std::copy_n(P_CRANE_UPPER, 6, upper);
    }
    static inline void f(const double *s, const double *u, double *d) {
        double sn = sin(s[2]), cs = cos(s[2]);
        double along = -(P_CRANE_LOAD * P_CRANE_GRAVITY + u[1]);  // the force on l
        double xdd = (u[0] - sn * along) / P_CRANE_TROLLEY;
        d[0] = s[3];
        d[1] = s[4];
        d[2] = s[5];
        d[3] = xdd;
        d[4] = along / P_CRANE_LOAD - sn * xdd + s[1] * s[5] * s[5] + P_CRANE_GRAVITY * cs;
        d[5] = -(2 * s[4] * s[5] + cs * xdd + P_CRANE_GRAVITY * sn) / s[1];
    }
    static inline void go_round(double *) {}
    static inline double from_goal(const double *s) {
        double square = 0;
        for (int i = 0; i < 6; ++i) {
            double gap = P_CRANE_GOAL_WEIGHT[i] * (s[i] - P_CRANE_GOAL[i]);
            square += gap * gap;
        }
        return sqrt(square);
    }
    static void in_goal(ompl::RNG &, double *s) { std::copy_n(P_CRANE_GOAL, 6, s); }
    static std::shared_ptr<fcl::CollisionGeometryd> body() {
        return std::make_shared<fcl::Boxd>(P_CRANE_EDGE, P_CRANE_EDGE, P_CRANE_EDGE);
    }
    static inline void place(const double *s, fcl::Matrix3d &R, fcl::Vector3d &p) {
        double c = cos(s[2]), n = sin(s[2]);
        R << c, 0, -n, 0, 1, 0, n, 0, c;
        p << s[0] + s[1] * n, 0, P_CRANE_HEIGHT - s[1] * c;
    }
    static inline double as_kinolab(const double *u, int i) {  // there the rope carries the weight
        return i == 0 ? u[0] : u[1] + P_CRANE_LOAD * P_CRANE_GRAVITY;
    }
    static constexpr auto &boxes = P_CRANE_BOXES;
};

template <class Machine>
static inline void rk4(double *s, const double *u, int count, double h) {
    double k1[6], k2[6], k3[6], k4[6], t[6];
    for (int j = 0; j < count; ++j) {
        Machine::f(s, u, k1);
        for (int i = 0; i < 6; ++i) t[i] = s[i] + 0.5 * h * k1[i];
        Machine::f(t, u, k2);
        for (int i = 0; i < 6; ++i) t[i] = s[i] + 0.5 * h * k2[i];
        Machine::f(t, u, k3);
        for (int i = 0; i < 6; ++i) t[i] = s[i] + h * k3[i];
        Machine::f(t, u, k4);
        for (int i = 0; i < 6; ++i) s[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    }
}

template <class Machine>
static inline void load(const ob::State *state, double *s) {
    const double *v = state->as<ob::RealVectorStateSpace::StateType>()->values;
    for (int i = 0; i < 6; ++i) s[i] = v[i] / Machine::weight[i];
}
template <class Machine>
static inline void store(const double *s, ob::State *state) {
    double *v = state->as<ob::RealVectorStateSpace::StateType>()->values;
    for (int i = 0; i < 6; ++i) v[i] = s[i] * Machine::weight[i];
}

static const double PER_SECOND = 0.1;  // as in versus/costs.py
static bool priced = false;

class Space : public ob::RealVectorStateSpace {  // the cost so far, if any, is no distance
public:
    Space() : ob::RealVectorStateSpace(priced ? 7 : 6) {}
    double distance(const ob::State *a, const ob::State *b) const override {
        const double *v = a->as<StateType>()->values, *w = b->as<StateType>()->values;
        double square = 0;
        for (int i = 0; i < 6; ++i) square += (v[i] - w[i]) * (v[i] - w[i]);
        return sqrt(square);
    }
};

class Effort : public ob::OptimizationObjective {
public:
    explicit Effort(const ob::SpaceInformationPtr &si) : ob::OptimizationObjective(si) {}
    ob::Cost stateCost(const ob::State *) const override { return identityCost(); }
    ob::Cost motionCost(const ob::State *a, const ob::State *b) const override {
        return ob::Cost(so_far(b) - so_far(a));
    }
    static double so_far(const ob::State *s) {
        return s->as<ob::RealVectorStateSpace::StateType>()->values[6];
    }
};

// ---- what happened --------------------------------------------------------------------------

struct Mark {
    long nodes;
    double cpu, resident;
    long propagations;
};

struct Progress {
    long propagations = 0, nodes = 1;
    double wall0 = 0, cpu0 = 0, wall_first = -1, cpu_first = -1;
    std::vector<long> sizes;  // at which a mark is due
    std::vector<Mark> marks;

    bool over() const {
        return priced ? false : sizes.empty() ? cpu_first >= 0 : marks.size() == sizes.size();
    }
    void asked_for_goal(bool inside) {  // planners ask once for every node that they add
        ++nodes;
        if (sizes.empty() && inside && cpu_first < 0) {
            wall_first = wall() - wall0, cpu_first = cpu() - cpu0;
        }
        while (marks.size() < sizes.size() && nodes >= sizes[marks.size()]) mark(nodes);
    }
    void mark(long size) { marks.push_back({size, cpu() - cpu0, resident_mb(), propagations}); }
};
static Progress progress;

// ---- OMPL's questions -----------------------------------------------------------------------

template <class Machine>
class Propagator : public oc::StatePropagator {
public:
    using oc::StatePropagator::StatePropagator;
    void propagate(const ob::State *from, const oc::Control *control, double duration,
                   ob::State *to) const override {
        ++progress.propagations;
        double s[6];
        load<Machine>(from, s);
        const double *u = control->as<oc::RealVectorControlSpace::ControlType>()->values;
        rk4<Machine>(s, u, P_SUBSTEPS, duration / P_SUBSTEPS);
        Machine::go_round(s);
        store<Machine>(s, to);
        if (!priced) return;
        double rate = PER_SECOND;
        for (int i = 0; i < 2; ++i) rate += pow(Machine::as_kinolab(u, i), 2);
        to->as<ob::RealVectorStateSpace::StateType>()->values[6] =
            from->as<ob::RealVectorStateSpace::StateType>()->values[6] + duration * rate;
    }
};

template <class Machine>
class World {  // a broad phase over meshes of boxes, and the machine's body
public:
    World() : body_(Machine::body()) {
        for (auto &box : Machine::boxes) obstacles_.push_back(mesh(box));
        for (auto &obstacle : obstacles_) manager_.registerObject(obstacle.get());
        manager_.setup();
    }
    bool collides(const double *s) {
        fcl::Matrix3d R;
        fcl::Vector3d p;
        Machine::place(s, R, p);
        body_.setTransform(R, p);
        body_.computeAABB();
        fcl::DefaultCollisionData<double> found;
        manager_.collide(&body_, &found, fcl::DefaultCollisionFunction<double>);
        return found.result.isCollision();
    }

private:
    static std::unique_ptr<fcl::CollisionObjectd> mesh(const double (&box)[6]) {
        static const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                         {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                         {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
        std::vector<fcl::Vector3d> corners;
        std::vector<fcl::Triangle> triangles;
        for (int i = 0; i < 8; ++i) {
            corners.emplace_back(box[0] + box[3] * ((i & 1) ? .5 : -.5),
                                 box[1] + box[4] * ((i & 2) ? .5 : -.5),
                                 box[2] + box[5] * ((i & 4) ? .5 : -.5));
        }
        for (auto &face : faces) triangles.emplace_back(face[0], face[1], face[2]);
        auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
        model->beginModel();
        model->addSubModel(corners, triangles);
        model->endModel();
        return std::make_unique<fcl::CollisionObjectd>(model);
    }
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> obstacles_;
    fcl::DynamicAABBTreeCollisionManagerd manager_;
    fcl::CollisionObjectd body_;
};

template <class Machine>
class Validity : public ob::StateValidityChecker {
public:
    using ob::StateValidityChecker::StateValidityChecker;
    bool isValid(const ob::State *state) const override {
        if (!si_->satisfiesBounds(state)) return false;
        double s[6];
        load<Machine>(state, s);
        return !world_.collides(s);
    }

private:
    mutable World<Machine> world_;
};

template <class Machine>
class Goal : public ob::GoalSampleableRegion {
public:
    explicit Goal(const ob::SpaceInformationPtr &si) : ob::GoalSampleableRegion(si) {
        setThreshold(progress.sizes.empty() ? Machine::goal_radius : 0.0);
    }
    double distanceGoal(const ob::State *state) const override {
        double s[6];
        load<Machine>(state, s);
        double distance = Machine::from_goal(s);
        progress.asked_for_goal(distance < threshold_);
        return distance;
    }
    void sampleGoal(ob::State *state) const override {
        double s[6];
        Machine::in_goal(random_, s);
        store<Machine>(s, state);
    }
    unsigned int maxSampleCount() const override { return 1000000000; }

private:
    mutable ompl::RNG random_;
};

// Cells of the first two entries, 20 along each. Debian's OMPL 1.5.2 fails an assertion in its own
// projection of a real vector.
template <class Machine>
class Plane : public ob::ProjectionEvaluator {
public:
    explicit Plane(const ob::StateSpacePtr &space) : ob::ProjectionEvaluator(space) {
        defaultCellSizes();
        setCellSizes(cellSizes_);
    }
    unsigned int getDimension() const override { return 2; }
    void defaultCellSizes() override {
        double lower[6], upper[6];
        Machine::limits(lower, upper);
        cellSizes_ = {(upper[0] - lower[0]) / 20, (upper[1] - lower[1]) / 20};
    }
    void project(const ob::State *state, Eigen::Ref<Eigen::VectorXd> p) const override {
        double s[6];
        load<Machine>(state, s);
        p(0) = s[0];
        p(1) = s[1];
    }
};

static ob::PlannerPtr planner_named(const std::string &name, const oc::SpaceInformationPtr &si) {
    if (name == "RRT") return std::make_shared<oc::RRT>(si);
    if (name == "SST") return std::make_shared<oc::SST>(si);
    if (name == "KPIECE1") return std::make_shared<oc::KPIECE1>(si);
    if (name == "EST") return std::make_shared<oc::EST>(si);
    if (name == "PDST") return std::make_shared<oc::PDST>(si);
    fprintf(stderr, "no planner is called %s: RRT, SST, KPIECE1, EST, PDST\n", name.c_str());
    exit(2);
}

template <class Machine>
static oc::SpaceInformationPtr space_information() {
    double lower[6], upper[6];
    Machine::limits(lower, upper);
    ob::RealVectorBounds bounds(priced ? 7 : 6), inputs(2);
    if (priced) bounds.setLow(6, 0), bounds.setHigh(6, 1e9);
    for (int i = 0; i < 6; ++i) {
        bounds.setLow(i, lower[i] * Machine::weight[i]);
        bounds.setHigh(i, upper[i] * Machine::weight[i]);
    }
    for (int i = 0; i < 2; ++i) {
        inputs.setLow(i, -Machine::input[i]);
        inputs.setHigh(i, Machine::input[i]);
    }
    std::shared_ptr<ob::RealVectorStateSpace> space = std::make_shared<Space>();
    if (!priced) space = std::make_shared<ob::RealVectorStateSpace>(6);
    space->setBounds(bounds);
    space->registerDefaultProjection(std::make_shared<Plane<Machine>>(space));
    auto controls = std::make_shared<oc::RealVectorControlSpace>(space, 2);
    controls->setBounds(inputs);
    auto si = std::make_shared<oc::SpaceInformation>(space, controls);
    si->setStatePropagator(std::make_shared<Propagator<Machine>>(si));
    si->setStateValidityChecker(std::make_shared<Validity<Machine>>(si));
    si->setPropagationStepSize(P_STEP);
    si->setMinMaxControlDuration(P_MIN_STEPS, P_MAX_STEPS);
    si->setup();
    return si;
}

template <class Machine>
static void print_path(const ob::PathPtr &path) {
    auto &motion = *path->as<oc::PathControl>();
    printf(",\"motion\":[");
    for (std::size_t k = 0; k < motion.getControlCount(); ++k) {
        const double *u = motion.getControl(k)->as<oc::RealVectorControlSpace::ControlType>()->values;
        long steps = std::lround(motion.getControlDuration(k) / P_STEP);
        printf("%s[%ld,%.17g,%.17g]", k ? "," : "", steps, Machine::as_kinolab(u, 0),
               Machine::as_kinolab(u, 1));
    }
    printf("]");
}

template <class Machine>
static int run(const std::string &name, double limit) {
    double begun = cpu();
    auto si = space_information<Machine>();
    auto question = std::make_shared<ob::ProblemDefinition>(si);
    ob::ScopedState<> start(si->getStateSpace());
    store<Machine>(Machine::start, start.get());
    if (priced) start.get()->as<ob::RealVectorStateSpace::StateType>()->values[6] = 0;
    question->addStartState(start);
    question->setGoal(std::make_shared<Goal<Machine>>(si));
    if (priced) question->setOptimizationObjective(std::make_shared<Effort>(si));
    auto planner = planner_named(name, si);
    planner->setProblemDefinition(question);
    planner->setup();

    double setup = cpu() - begun;
    progress.propagations = 0, progress.nodes = 1;
    progress.wall0 = wall(), progress.cpu0 = cpu();
    Mark first{1, 0.0, resident_mb(), 0};
    long looks = 0;  // asking for the time is dear
    auto over = ob::PlannerTerminationCondition([&] {
        return progress.over() || (++looks % 64 == 0 && cpu() - progress.cpu0 > limit);
    });
    bool solved = planner->solve(over) == ob::PlannerStatus::EXACT_SOLUTION;
    double spent = cpu() - progress.cpu0;
    ob::PlannerData data(si);
    planner->getPlannerData(data);

    solved = solved && progress.cpu_first >= 0;
    printf("{\"solved\":%s,\"cpu\":%.6f,\"wall\":%.6f,\"setup\":%.6f,\"spent\":%.6f,"
           "\"propagations\":%ld,\"nodes\":%u",
           solved ? "true" : "false", solved ? progress.cpu_first : limit,
           solved ? progress.wall_first : limit, setup, spent, progress.propagations,
           data.numVertices());
    if (solved) print_path<Machine>(question->getSolutionPath());
    printf(",\"marks\":[");
    progress.marks.insert(progress.marks.begin(), first);
    const char *comma = "";
    for (auto &mark : progress.marks) {
        printf("%s{\"nodes\":%ld,\"cpu\":%.6f,\"resident\":%.3f,\"propagations\":%ld}", comma,
               mark.nodes, mark.cpu, mark.resident, mark.propagations);
        comma = ",";
    }
    printf("]}\n");
    return 0;
}

int main(int count, char **given) {
    if (count == 2 && !strcmp(given[1], "version")) {
        printf("OMPL %d.%d.%d, FCL %s, compiler %s\n", OMPL_MAJOR_VERSION, OMPL_MINOR_VERSION,
               OMPL_PATCH_VERSION, FCL_VERSION, __VERSION__);
        return 0;
    }
    if (count < 5) {
        fprintf(stderr, "usage: baseline <disk|crane> <planner> <seed> <limit> [nodes ...]\n");
        return 2;
    }
    std::string problem = given[1], name = given[2];
    priced = name.rfind("effort:", 0) == 0;
    if (priced) name = name.substr(7);
    ompl::RNG::setSeed(atoi(given[3]));
    ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
    for (int i = 5; i < count; ++i) progress.sizes.push_back(atol(given[i]));
    if (problem == "disk") return run<Disk>(name, atof(given[4]));
    if (problem == "crane") return run<Crane>(name, atof(given[4]));
    fprintf(stderr, "no problem is called %s: disk, crane\n", given[1]);
    return 2;
}
