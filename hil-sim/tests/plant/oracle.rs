//! A second simulator, written from the body's equations and with another idea
//! of friction: short fixed steps, each of which finds the friction impulses
//! that are within their bounds and oppose what motion is left (Moreau's time
//! stepping). It knows no modes, no events and no step control. Slow, and
//! right to some parts in a hundred thousand.

use canloop::robot::{Model, Pose, Robot};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, State, Torque};

const STEP_S: f64 = 1e-7;

pub struct Oracle {
    robot: Robot,
    friction: [Friction; 2],
    inertia: [[f64; 2]; 2],
    angle: [f64; 2],
    speed: [f64; 2],
    pose: Pose,
}

impl Oracle {
    pub fn new(robot: Robot, friction: Wheels<Friction>, start: Pose) -> Self {
        let columns = [wheel_torque(&robot, [1.0, 0.0]), wheel_torque(&robot, [0.0, 1.0])];
        Self {
            robot,
            friction: [friction.right, friction.left],
            inertia: [[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]],
            angle: [0.0; 2],
            speed: [0.0; 2],
            pose: start,
        }
    }

    pub fn advance(&mut self, span_s: f64, torque: Wheels<Torque>) {
        let steps = (span_s / STEP_S).round().max(1.0);
        let h = span_s / steps;
        let decay = |torque: Torque| if torque.excess_nm == 0.0 { 1.0 } else { libm::exp(-h / torque.time_constant_s) };
        let decay = [decay(torque.right), decay(torque.left)];
        let mut excess = [torque.right.excess_nm, torque.left.excess_nm];
        for _ in 0..steps as usize {
            let next = [excess[0] * decay[0], excess[1] * decay[1]];
            let nm = [
                torque.right.final_nm + 0.5 * (excess[0] + next[0]),
                torque.left.final_nm + 0.5 * (excess[1] + next[1]),
            ];
            self.step(h, nm);
            excess = next;
        }
    }

    pub fn state(&self) -> State {
        let pair = |[right, left]: [f64; 2]| Wheels { right, left };
        State { angle_rad: pair(self.angle), speed_rad_s: pair(self.speed), pose: self.pose }
    }

    fn step(&mut self, h: f64, torque_nm: [f64; 2]) {
        let guess = self.speeds_after(h, torque_nm, self.speed);
        let middle = [0.5 * (self.speed[0] + guess[0]), 0.5 * (self.speed[1] + guess[1])];
        let speed = self.speeds_after(h, torque_nm, middle);
        let mean = [0.5 * (self.speed[0] + speed[0]), 0.5 * (self.speed[1] + speed[1])];
        let (v, p) = body_rates(&self.robot, mean);
        let heading = self.pose.heading_rad + 0.5 * h * p;
        self.pose.x_m += h * v * libm::cos(heading);
        self.pose.y_m += h * v * libm::sin(heading);
        self.pose.heading_rad += h * p;
        self.angle = [self.angle[0] + h * mean[0], self.angle[1] + h * mean[1]];
        self.speed = speed;
    }

    /// Speeds at the end of a step whose forces are taken at the speeds `at`.
    fn speeds_after(&self, h: f64, torque_nm: [f64; 2], at: [f64; 2]) -> [f64; 2] {
        let velocity = velocity_torque(&self.robot, at);
        let level = |i: usize| {
            let Friction { static_nm, coulomb_nm, stribeck_s_per_rad, .. } = self.friction[i];
            h * (coulomb_nm + (static_nm - coulomb_nm) * libm::exp(-stribeck_s_per_rad * at[i].abs()))
        };
        let level = [level(0), level(1)];
        let m = &self.inertia;
        let free = |i: usize| {
            let smooth = torque_nm[i] + velocity[i] - self.friction[i].viscous_nm_s_per_rad * at[i];
            m[i][0] * self.speed[0] + m[i][1] * self.speed[1] + h * smooth
        };
        let momentum = [free(0), free(1)];
        let mut speed = self.speed;
        // Gauss-Seidel: each wheel in turn, the other's speed given.
        for _ in 0..50 {
            let before = speed;
            for i in 0..2 {
                let left = momentum[i] - m[i][1 - i] * speed[1 - i];
                speed[i] = (left - left.clamp(-level[i], level[i])) / m[i][i];
            }
            if speed == before {
                break;
            }
        }
        speed
    }
}

fn body_rates(robot: &Robot, wheels: [f64; 2]) -> (f64, f64) {
    let Robot { wheel_radius_m: r, half_track_m: b, .. } = *robot;
    (r * (wheels[0] + wheels[1]) / 2.0, r * (wheels[0] - wheels[1]) / (2.0 * b))
}

/// The wheel torques that bring a force and a moment to the body.
fn through_the_wheels(robot: &Robot, force: f64, moment: f64) -> [f64; 2] {
    let Robot { wheel_radius_m: r, half_track_m: b, .. } = *robot;
    [r * (force + moment / b) / 2.0, r * (force - moment / b) / 2.0]
}

/// Torque that accelerates the wheels so, from rest: momentum of the body and
/// of everything that turns with a wheel.
fn wheel_torque(robot: &Robot, acceleration: [f64; 2]) -> [f64; 2] {
    let mass = robot.mass_kg + robot.load.mass_kg;
    let right = robot.load.cog_distance_m * libm::cos(robot.load.cog_angle_rad);
    let d2 = robot.load.cog_distance_m * robot.load.cog_distance_m;
    let twice = if robot.model == Model::Paper { mass * right * right } else { 0.0 };
    let (v, p) = body_rates(robot, acceleration);
    let force = mass * (v + right * p);
    let moment = (robot.inertia_kg_m2 + mass * d2 + twice) * p + mass * right * v;
    let body = through_the_wheels(robot, force, moment);
    let own = robot.wheel_inertia_kg_m2 + robot.motor_inertia_kg_m2 * robot.gear_ratio * robot.gear_ratio;
    [own * acceleration[0] + body[0], own * acceleration[1] + body[1]]
}

fn velocity_torque(robot: &Robot, speed: [f64; 2]) -> [f64; 2] {
    if robot.model == Model::Paper {
        return [0.0; 2];
    }
    let lateral =
        (robot.mass_kg + robot.load.mass_kg) * robot.load.cog_distance_m * libm::sin(robot.load.cog_angle_rad);
    let (v, p) = body_rates(robot, speed);
    through_the_wheels(robot, lateral * p * p, -lateral * v * p)
}
