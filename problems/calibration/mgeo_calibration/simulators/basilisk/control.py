"""Guidance and control modules of the Basilisk simulation, based on the gyro."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from Basilisk.architecture import messaging, sysModel
from Basilisk.fswAlgorithms import attTrackingError, mrpFeedback, rwMotorTorque
from Basilisk.simulation import MtbEffector, reactionWheelStateEffector
from Basilisk.utilities import RigidBodyKinematics, simIncludeRW
from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.motion import Motion
from scipy.spatial.transform import Rotation

from mgeo_calibration.simulators.basilisk.vehicle import MagnetorquerVehicle, Vehicle

#: Speed of a wheel at its largest momentum [rpm], which defines the inertia of the wheel.
WHEEL_SPEED = 6000.0

#: Inertia of a wheel without momentum limit, relative to the satellite's smallest inertia.
WHEEL_INERTIA_RATIO = 1e-3

DAMPING_RATIO = 0.7


@dataclass(frozen=True)
class Reference:
    """Reference attitude, rate and acceleration of the controller at the boundaries of n simulation
    steps.

    Attributes
    ----------
    attitude : array, shape (n + 1, 3)
        Modified Rodrigues parameters.
    rate, acceleration : array, shape (n + 1, 3)
        Body rate [rad/s] and angular acceleration [rad/s²] in GCRS axes.
    """

    attitude: Floats
    rate: Floats
    acceleration: Floats

    @classmethod
    def from_motion(
        cls, motion: Motion, initial_rate: Floats, step: float, n_substeps: int
    ) -> Reference:
        """Build the controller reference of a planned motion with a constant rate in each filter
        step.

        The rate at the boundary of two steps is the mean of both rates, as on a linear ramp.

        Parameters
        ----------
        initial_rate : array, shape (3,)
            Body rate before the first step [rad/s].
        step : float
            Duration of a step of the motion [s].
        n_substeps : int
            Number of simulation steps per step of the motion.
        """
        h, rates = step / n_substeps, np.repeat(motion.rates, n_substeps, axis=0)
        rotations = np.tile(h * np.arange(n_substeps), len(motion.rates))[:, None] * rates
        within = Rotation.from_rotvec(-rotations).as_matrix()
        to_body = np.concatenate(
            [within @ np.repeat(motion.attitude[:-1], n_substeps, axis=0), motion.attitude[-1:]]
        )
        before, after = np.vstack([initial_rate, rates]), np.vstack([rates, rates[-1:]])
        mean, change = 0.5 * (before + after), np.vstack([after[1:], after[-1:]]) - before
        return cls(
            Rotation.from_matrix(to_body).inv().as_mrp(),
            np.einsum("kji,kj->ki", to_body, mean),
            np.einsum("kji,kj->ki", to_body, 0.5 * change / h),
        )


class Guidance(sysModel.SysModel):
    """Basilisk module that estimates the attitude from gyro rates, and sends the estimate and the
    reference to the controller.

    The initial attitude and rate are the planned values. The attitude is propagated with the
    measured rates, corrected by the estimated gyro errors; the remaining errors are not observed.
    The module also sets the bias of the simulated gyro in each step.
    """

    def __init__(
        self,
        imu: Any,
        reference: Reference,
        initial_rate: Floats,
        correct_rate: Callable[[Floats], Floats],
        bias: Floats,
        step_ns: int,
    ) -> None:
        super().__init__()
        self.ModelTag = "guidance"
        self.navigation, self.reference_message = messaging.NavAttMsg(), messaging.AttRefMsg()
        self._imu, self._reference, self._bias = imu, reference, bias
        self._step_ns = step_ns
        self._initial_rate, self._correct_rate = initial_rate, correct_rate
        self._attitude = reference.attitude[0]
        self.referenced_messages: tuple[Any, ...] = ()

    def Reset(self, nanoseconds: int) -> None:
        self._attitude = self._reference.attitude[0]
        self._write(nanoseconds, self._initial_rate)

    def UpdateState(self, nanoseconds: int) -> None:
        if nanoseconds == 0:  # There is no measurement yet.
            self._write(nanoseconds, self._initial_rate)
            return
        measured = self._imu.sensorOutMsg.read()
        step = 1e-9 * self._step_ns
        rate = self._correct_rate(np.array(measured.DRFramePlatform) / step)
        step_rotation = Rotation.from_rotvec(rate * step).as_mrp()
        self._attitude = RigidBodyKinematics.addMRP(self._attitude, step_rotation)
        self._write(nanoseconds, self._correct_rate(np.array(measured.AngVelPlatform)))

    def _write(self, nanoseconds: int, rate: Any) -> None:
        k = round(nanoseconds / self._step_ns)
        self._imu.senRotBias = self._bias[min(k, len(self._bias) - 1)]  # valid until the next step
        now, reference = messaging.NavAttMsgPayload(), messaging.AttRefMsgPayload()
        now.sigma_BN, now.omega_BN_B = self._attitude, rate
        reference.sigma_RN = self._reference.attitude[k]
        reference.omega_RN_N = self._reference.rate[k]
        reference.domega_RN_N = self._reference.acceleration[k]
        self.navigation.write(now, nanoseconds, self.moduleID)
        self.reference_message.write(reference, nanoseconds, self.moduleID)


def add_reaction_wheels(vehicle: Vehicle, satellite: Any, rate: Floats) -> tuple[Any, Any]:
    """Attach reaction wheels to a Basilisk satellite, with initial momentum and limits.

    Initial speeds follow `Vehicle.compute_initial_momentum`. A wheel at its momentum limit cannot
    accelerate further.

    Parameters
    ----------
    rate : array, shape (3,)
        Initial body rate [rad/s].

    Returns
    -------
    effector, message
        Wheel effector and its configuration message.
    """
    factory, wheels = simIncludeRW.rwFactory(), vehicle.wheels
    rpm = 2.0 * np.pi / 60.0
    speed = WHEEL_SPEED * rpm
    limits: dict[str, Any] = {
        "Js": WHEEL_INERTIA_RATIO * min(wheels.inertia),
        "useMaxTorque": False,
    }
    if wheels.max_momentum is not None:
        limits |= {"Js": wheels.max_momentum / speed, "Omega_max": WHEEL_SPEED}
    if wheels.max_torque is not None:
        limits |= {"useMaxTorque": True, "u_max": wheels.max_torque}
    for axis, momentum in zip(
        wheels.normalized_axes(), vehicle.compute_initial_momentum(rate), strict=True
    ):
        spin = float(momentum / limits["Js"] / rpm)
        factory.create("custom", axis.tolist(), Omega=spin, **limits)
    effector = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", effector, satellite)
    return effector, factory.getConfigMessage()


def build_control_loop(
    vehicle: Vehicle, guidance: Guidance, effector: Any, configuration: Any
) -> Sequence[Any]:
    """Build the Basilisk modules for attitude error, feedback law and wheel torques, in the order
    of execution.
    """
    inertia = vehicle.wheels.inertia_matrix()
    error = attTrackingError.attTrackingError()
    error.attNavInMsg.subscribeTo(guidance.navigation)
    error.attRefInMsg.subscribeTo(guidance.reference_message)
    feedback, largest = mrpFeedback.mrpFeedback(), float(np.linalg.eigvalsh(inertia)[-1])
    feedback.K = 4.0 * largest * vehicle.bandwidth**2  # An MRP is a quarter of the angle.
    feedback.P = 2.0 * DAMPING_RATIO * largest * vehicle.bandwidth
    feedback.Ki = -1.0  # Negative values disable the integral term.
    body = messaging.VehicleConfigMsgPayload()
    body.ISCPntB_B = inertia.ravel().tolist()
    satellite = messaging.VehicleConfigMsg().write(body)
    feedback.guidInMsg.subscribeTo(error.attGuidOutMsg)
    feedback.vehConfigInMsg.subscribeTo(satellite)
    feedback.rwParamsInMsg.subscribeTo(configuration)
    feedback.rwSpeedsInMsg.subscribeTo(effector.rwSpeedOutMsg)
    motors = rwMotorTorque.rwMotorTorque()
    motors.controlAxes_B = np.eye(3).ravel().tolist()
    motors.vehControlInMsg.subscribeTo(feedback.cmdTorqueOutMsg)
    motors.rwParamsInMsg.subscribeTo(configuration)
    effector.rwMotorCmdInMsg.subscribeTo(motors.rwMotorTorqueOutMsg)
    # Subscribers do not own their messages. This reference keeps the messages alive.
    guidance.referenced_messages = configuration, satellite
    return error, feedback, motors


def build_magnetorquer_control(
    vehicle: MagnetorquerVehicle,
    satellite: Any,
    field: Any,
    imu: Any,
    correct_rate: Callable[[Floats], Floats],
    bias: Floats,
    timing: tuple[int, int, Floats],
) -> tuple[Any, Sequence[Any]]:
    """Attach magnetorquers along the body axes to a Basilisk satellite, and build their controller.

    Parameters
    ----------
    correct_rate : function
        Corrects a measured rate by the estimated gyro errors.
    bias : array, shape (n, 3)
        Gyro bias in each simulation step [rad/s].
    timing : int, int, array of shape (3,)
        Duration of a simulation step [ns], number of simulation steps per filter step, and initial
        body rate [rad/s].
    """
    drive, (nanoseconds, n_substeps, initial_rate) = vehicle.drive, timing

    class Controller(sysModel.SysModel):
        """Basilisk module of a cross-product control law that uses gyro rates and the true field.
        The module also sets the gyro bias.
        """

        def __init__(self) -> None:
            super().__init__()
            self.ModelTag, self.dipoles = "magnetorquers", messaging.MTBCmdMsg()
            self.off = True
            self.referenced_messages: tuple[Any, ...] = ()

        def Reset(self, now: int) -> None:
            self.off = True
            self.dipoles.write(messaging.MTBCmdMsgPayload(), now, self.moduleID)

        def UpdateState(self, now: int) -> None:
            k = round(now / nanoseconds)
            imu.senRotBias = bias[min(k, len(bias) - 1)]  # valid until the next step
            if k % n_substeps or k // n_substeps >= len(vehicle.rates):
                return
            rate = initial_rate
            if k > 0:
                rate = correct_rate(np.array(imu.sensorOutMsg.read().AngVelPlatform))
            attitude = RigidBodyKinematics.MRP2C(satellite.scStateOutMsg.read().sigma_BN)
            b = attitude @ np.array(field.envOutMsgs[0].read().magField_N)
            error = rate - vehicle.rates[k // n_substeps]
            self.off = self.off and not vehicle.maneuver_starts[k // n_substeps]
            self.off = self.off or bool(np.linalg.norm(error) <= drive.rate_tolerance)
            torque = (
                np.cross(rate, drive.inertia @ rate) - drive.inertia @ error / drive.time_constant
            )
            dipole = np.cross(b, torque) / (b @ b)
            dipole /= max(1.0, float(np.abs(dipole / drive.max_dipole).max()))
            command = messaging.MTBCmdMsgPayload()
            command.mtbDipoleCmds = (dipole * (not self.off) + drive.residual_dipole).tolist()
            self.dipoles.write(command, now, self.moduleID)

    controller, magnetorquers = Controller(), MtbEffector.MtbEffector()
    magnetorquers.ModelTag = "magnetorquers"
    array = messaging.MTBArrayConfigMsgPayload()
    array.numMTB, array.GtMatrix_B = 3, np.eye(3).ravel().tolist()
    array.maxMtbDipoles = (drive.max_dipole + np.abs(drive.residual_dipole)).tolist()
    parameters = messaging.MTBArrayConfigMsg().write(array)
    magnetorquers.mtbParamsInMsg.subscribeTo(parameters)
    magnetorquers.mtbCmdInMsg.subscribeTo(controller.dipoles)
    magnetorquers.magInMsg.subscribeTo(field.envOutMsgs[0])
    satellite.addDynamicEffector(magnetorquers)
    # Subscribers do not own their messages, so that a reference keeps them alive.
    controller.referenced_messages = (parameters,)
    return magnetorquers, (controller,)
