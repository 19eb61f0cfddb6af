"""The robot of eq 1-8 in numpy: two wheels with friction that truly sticks, and
the pose that follows from them.

While no wheel comes to rest or breaks loose the motion is smooth, and a
Runge-Kutta step serves; the instants at which one does are found by bisection.
"""

import itertools

import numpy as np

# A step spans so much of the time constants of the Stribeck term and of the
# drives' current loops.
STRIBECK_STEP = 0.2
LAG_STEP = 1.0
# From so many times 1/a on the Stribeck term is gone.
STRIBECK_END = 40.0
# A wheel that leaves rest and would be back within this time never left.
SHORTEST_SLIP_S = 1e-6
ROUNDING_NM = 1e-9
BISECTIONS = 40


class Lag:
    """The torque of both wheels while the current loops go over to another."""

    def __init__(self, now_nm, final_nm, time_constant_s):
        self.excess_nm, self.final_nm, self.time_constant_s = now_nm - final_nm, final_nm, time_constant_s

    def at(self, t_s):
        return self.final_nm + self.excess_nm * np.exp(-t_s / self.time_constant_s)

    def mean(self, span_s):
        share = self.time_constant_s / span_s
        return self.final_nm + self.excess_nm * share * -np.expm1(-1.0 / share)


def mass_matrix(robot, load):
    total_kg = robot["mass_kg"] + load["mass_kg"]
    half_track_m, cog_m = robot["half_track_m"], load["cog_distance_m"]
    right_m = cog_m * np.cos(load["cog_angle_rad"])
    arms_m = np.array([half_track_m + right_m, half_track_m - right_m])
    c = (robot["wheel_radius_m"] / (2.0 * half_track_m)) ** 2
    q = c * (robot["inertia_kg_m2"] + cog_m**2 * total_kg)
    j = robot["wheel_inertia_kg_m2"] + robot["gear_ratio"] ** 2 * robot["motor_inertia_kg_m2"]
    return c * total_kg * np.outer(arms_m, arms_m) + q * np.array([[1.0, -1.0], [-1.0, 1.0]]) + j * np.eye(2)


class Plant:
    """State: angles and speeds of the right and the left wheel, x, y, heading."""

    def __init__(self, robot, start):
        self.mass = mass_matrix(robot, robot["load"])
        self.mobilities = {slips: self.mobility(slips) for slips in itertools.product((False, True), repeat=2)}
        friction = robot["friction"]
        self.viscous, self.stribeck = friction["viscous_nm_s_per_rad"], friction["stribeck_s_per_rad"]
        self.static_nm, self.coulomb_nm = friction["static_nm"], friction["coulomb_nm"]
        self.radius_m, self.half_track_m = robot["wheel_radius_m"], robot["half_track_m"]
        self.state = np.array([0.0, 0.0, 0.0, 0.0, start["x_m"], start["y_m"], start["heading_rad"]])

    def mobility(self, slips):
        """Acceleration per torque where these wheels slip and the others stick."""
        if all(slips):
            return np.linalg.inv(self.mass)
        return np.diag([1.0 / self.mass[wheel, wheel] if slips[wheel] else 0.0 for wheel in (0, 1)])

    @property
    def angles_rad(self):
        return self.state[0:2]

    def advance(self, span_s, torque):
        at_s = 0.0
        while at_s < span_s:
            at_s += self.step(at_s, span_s - at_s, torque)

    def step(self, at_s, left_s, torque):
        """One step, not beyond the instant at which a wheel stops or breaks loose."""
        grip = self.grip(torque.at(at_s))
        step_s = self.step_limit(at_s, left_s, grip, torque)
        after = self.runge_kutta(at_s, step_s, grip, torque)
        while self.has_returned(grip, after):
            if step_s < SHORTEST_SLIP_S:
                grip = np.where(self.state[2:4] == 0.0, 0.0, grip)
            else:
                step_s *= 0.5
            after = self.runge_kutta(at_s, step_s, grip, torque)
        if self.margin(at_s + step_s, after, grip, torque) < 0.0:
            step_s, after = self.up_to_end(at_s, step_s, grip, torque)
            stopped = (self.state[2:4] != 0.0) & (grip * after[2:4] < 1e-12)
            after[2:4][stopped] = 0.0
        self.state = after
        return step_s

    def has_returned(self, grip, after):
        return np.any((self.state[2:4] == 0.0) & (grip * after[2:4] < 0.0))

    def up_to_end(self, at_s, beyond_s, grip, torque):
        low_s, high_s = 0.0, beyond_s
        for _ in range(BISECTIONS):
            middle_s = 0.5 * (low_s + high_s)
            after = self.runge_kutta(at_s, middle_s, grip, torque)
            if self.margin(at_s + middle_s, after, grip, torque) < 0.0:
                high_s = middle_s
            else:
                low_s = middle_s
        return high_s, self.runge_kutta(at_s, high_s, grip, torque)

    def runge_kutta(self, at_s, step_s, grip, torque):
        mobility = self.mobilities[bool(grip[0]), bool(grip[1])]
        torque_nm, middle_nm, end_nm = torque.at(at_s), torque.at(at_s + 0.5 * step_s), torque.at(at_s + step_s)
        k1 = self.derivative(self.state, mobility, grip, torque_nm)
        k2 = self.derivative(self.state + 0.5 * step_s * k1, mobility, grip, middle_nm)
        k3 = self.derivative(self.state + 0.5 * step_s * k2, mobility, grip, middle_nm)
        k4 = self.derivative(self.state + step_s * k3, mobility, grip, end_nm)
        return self.state + step_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def derivative(self, state, mobility, grip, torque_nm):
        speeds_rad_s, heading_rad = state[2:4], state[6]
        acceleration_rad_s2 = mobility @ (torque_nm - self.friction_nm(speeds_rad_s, grip))
        right_m_s, left_m_s = self.radius_m * speeds_rad_s
        speed_m_s = 0.5 * (right_m_s + left_m_s)
        yaw_rate_rad_s = (right_m_s - left_m_s) / (2.0 * self.half_track_m)
        motion = [speed_m_s * np.cos(heading_rad), speed_m_s * np.sin(heading_rad), yaw_rate_rad_s]
        return np.concatenate([speeds_rad_s, acceleration_rad_s2, motion])

    def friction_nm(self, speeds_rad_s, grip):
        """Of slipping wheels, eq 6-8; a stuck wheel's is whatever holds it."""
        decay = np.exp(np.minimum(-self.stribeck * grip * speeds_rad_s, 1.0))
        dry_nm = self.coulomb_nm + (self.static_nm - self.coulomb_nm) * decay
        return self.viscous * speeds_rad_s + grip * dry_nm

    def grip(self, torque_nm):
        """For each wheel 0 if it sticks, else the direction in which it slips: what
        is at rest is decided together, since each wheel feels the other."""
        speeds_rad_s = self.state[2:4]
        if np.all(speeds_rad_s != 0.0):
            return np.sign(speeds_rad_s)
        choices = [(np.sign(speed),) if speed else (0.0, 1.0, -1.0) for speed in speeds_rad_s]
        grips = [np.array(grip) for grip in itertools.product(*choices)]
        return min(grips, key=lambda grip: self.contradiction_nm(grip, torque_nm))

    def contradiction_nm(self, grip, torque_nm):
        speeds_rad_s = self.state[2:4]
        net_nm = torque_nm - self.friction_nm(speeds_rad_s, grip)
        acceleration_rad_s2 = self.mobilities[bool(grip[0]), bool(grip[1])] @ net_nm
        held_nm = net_nm - self.mass[0, 1] * acceleration_rad_s2[::-1]
        too_much_nm = np.abs(held_nm) - self.static_nm
        backwards_nm = -grip * acceleration_rad_s2 * np.diag(self.mass) - ROUNDING_NM
        off_nm = np.where(grip == 0.0, too_much_nm, np.where(speeds_rad_s == 0.0, backwards_nm, 0.0))
        return max(0.0, off_nm.max())

    def margin(self, t_s, state, grip, torque):
        """Below zero once a slipping wheel has passed rest or a stuck one breaks loose."""
        speeds_rad_s = state[2:4]
        if grip.all():
            return (grip * speeds_rad_s).min()
        net_nm = torque.at(t_s) - self.friction_nm(speeds_rad_s, grip)
        acceleration_rad_s2 = self.mobilities[bool(grip[0]), bool(grip[1])] @ net_nm
        reserve_nm = self.static_nm - np.abs(net_nm - self.mass[0, 1] * acceleration_rad_s2[::-1])
        return np.where(grip == 0.0, reserve_nm, grip * speeds_rad_s).min()

    def step_limit(self, at_s, left_s, grip, torque):
        """As long as the physics allows."""
        limit_s = min(left_s, LAG_STEP * torque.time_constant_s)
        if not grip.any():
            return limit_s
        speeds_rad_s = self.state[2:4]
        mobility = self.mobilities[bool(grip[0]), bool(grip[1])]
        distance = self.stribeck * np.abs(speeds_rad_s)
        acceleration_rad_s2 = mobility @ (torque.at(at_s) - self.friction_nm(speeds_rad_s, grip))
        rate_hz = self.stribeck * (self.static_nm - self.coulomb_nm) * np.exp(-distance) @ np.diag(mobility)
        travel = np.where(distance > STRIBECK_END + 5.0, distance - STRIBECK_END, 0.4 + 0.1 * distance)
        travel_hz = np.max(self.stribeck * np.abs(acceleration_rad_s2) / travel)
        return limit_s / max(1.0, limit_s * rate_hz / STRIBECK_STEP, limit_s * travel_hz)
