"""Loads files that foldpath has exported into physics engines and other programs and prints what these find, as one JSON
object.

    judge.py loops FOLDER     sets every hinge of the tree along the motion; the largest error of a loop, in units of
                              the sheet, by MuJoCo's own kinematics
    judge.py drive FOLDER     starts 2 % up the path, moves the actuators alone along the motion, and waits for a second;
                              the largest distance of a hinge from the goal in degrees
    judge.py plates FOLDER    sets every hinge of the tree along the motion; the least distance of two panels that are meshes,
                              below 0 if they are in each other, over the extent of the model
    judge.py loads FOLDER     the torques of the drivers of loads.json that hold the sheet at rest along the motion
    judge.py drake FOLDER     loads the model into Drake and counts
    judge.py shop FOLDER      loads STL and DXF files for the workshop: each solid's volume, and whether it is closed; errors of
                              drawings, and the number of entities of each layer

FOLDER has the model (scene.xml and meshes) and motion.csv, the angles of all hinges in degrees at a fixed rate; for `shop` it
has folders 0, 1 and so on with STL and DXF files.
"""

import collections
import csv
import json
import pathlib
import sys

import numpy

# Fraction of the path at which a driven sheet starts: flat itself is a branch point.
START = 0.02
# Time after the motion for the sheet to come to rest, seconds.
REST = 1.0


def motion(folder):
    """Returns the times (seconds) and the angles (radians) of each edge."""
    with open(folder / "motion.csv", newline="") as file:
        rows = list(csv.reader(file))
    table = numpy.array([[float(cell) for cell in row] for row in rows[1:]])
    angles = {name: numpy.radians(table[:, column]) for column, name in enumerate(rows[0]) if column > 0}
    return table[:, 0], angles


def load(folder):
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    times, angles = motion(folder)
    joints = [model.joint(index) for index in range(model.njnt)]
    addresses = [int(joint.qposadr[0]) for joint in joints]
    table = numpy.array([angles[joint.name.replace("crease_", "edge_")] for joint in joints]).T
    return mujoco, model, mujoco.MjData(model), times, addresses, table


def loops(folder):
    mujoco, model, data, times, addresses, table = load(folder)
    first, second = model.eq_obj1id, model.eq_obj2id
    assert all(kind == mujoco.mjtEq.mjEQ_CONNECT for kind in model.eq_type)

    def anchors(bodies, places):
        turned = numpy.einsum("kij,kj->ki", data.xmat[bodies].reshape(-1, 3, 3), places)
        return data.xpos[bodies] + turned

    worst = 0.0
    for row in table:
        data.qpos[addresses] = row
        mujoco.mj_kinematics(model, data)
        gaps = anchors(first, model.eq_data[:, 0:3]) - anchors(second, model.eq_data[:, 3:6])
        worst = max(worst, numpy.linalg.norm(gaps, axis=1).max(initial=0.0))
    return {"times": len(times), "bodies": model.nbody - 1, "joints": model.njnt, "loops": model.neq // 2, "error": worst}


def loads(folder):
    """Returns the torques of the drivers for each gravity and time: N^T qfrc_inverse at rest, with the motions N that the
    engine's Jacobian of the loops leaves free, the drivers' rows of which are the identity."""
    mujoco, model, data, times, addresses, table = load(folder)
    asked = json.loads((folder / "loads.json").read_text())
    names = [model.joint(index).name for index in range(model.njnt)]
    drivers = [int(model.jnt_dofadr[names.index(f"crease_{edge}")]) for edge in asked["drivers"]]
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    # Layers that lie on each other hold each other; the torques asked for leave that out.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    answer = [[] for _ in asked["gravities"]]
    for row in table:
        data.qpos[addresses] = row
        data.qvel[:] = 0.0
        data.qacc[:] = 0.0
        data.ctrl[:] = 0.0
        mujoco.mj_inverse(model, data)
        loops = data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        jacobian = data.efc_J[: data.nefc * model.nv].reshape(data.nefc, model.nv)[loops]
        free = numpy.eye(model.nv)
        if len(jacobian):
            _, values, rows = numpy.linalg.svd(jacobian)
            free = rows[int((values > 1e-6 * values.max()).sum()) :].T
        assert free.shape[1] == len(drivers), (free.shape, len(drivers))
        motions = free @ numpy.linalg.inv(free[drivers])
        for gravity, of_gravity in zip(asked["gravities"], answer):
            model.opt.gravity[:] = gravity
            mujoco.mj_inverse(model, data)
            of_gravity.append((motions.T @ data.qfrc_inverse).tolist())
    return answer


def plates(folder):
    mujoco, model, data, times, addresses, table = load(folder)
    worst = numpy.inf
    for row in table:
        data.qpos[addresses] = row
        mujoco.mj_kinematics(model, data)
        for a in range(model.ngeom):
            for b in range(a):
                apart = numpy.linalg.norm(data.geom_xpos[a] - data.geom_xpos[b])
                if apart <= model.geom_rbound[a] + model.geom_rbound[b]:
                    worst = min(worst, mujoco.mj_geomDistance(model, data, a, b, 1.0, None))
    return {"times": len(times), "worst": worst / model.stat.extent}


def drive(folder):
    mujoco, model, data, times, addresses, table = load(folder)
    end = times[-1]
    driven = [addresses.index(int(model.jnt_qposadr[model.actuator_trnid[k, 0]])) for k in range(model.nu)]
    at = lambda time, joint: numpy.interp(time, times, table[:, joint])
    start = START * end
    data.qpos[addresses] = [at(start, joint) for joint in range(len(addresses))]
    for step in range(int((end - start + REST) / model.opt.timestep)):
        time = start + step * model.opt.timestep
        data.ctrl[:] = [at(time, joint) for joint in driven]
        mujoco.mj_step(model, data)
    errors = numpy.abs(data.qpos[addresses] - table[-1])
    unstable = any(warning.number > 0 for warning in data.warning)
    return {"actuators": model.nu, "degrees": float(numpy.degrees(errors.max())), "unstable": unstable}


def drake(folder):
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, DiscreteContactApproximation
    from pydrake.systems.framework import DiagramBuilder

    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.001)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    Parser(plant).AddModels(str(folder / "scene.xml"))
    plant.Finalize()
    # The world is a body too, and each loop is two constraints.
    loops = plant.num_constraints() // 2
    return {"bodies": plant.num_bodies() - 1, "joints": plant.num_positions(), "loops": loops}


def shop(folder):
    return [shop_of(folder / str(sheet)) for sheet in range(len(list(folder.iterdir())))]


def shop_of(folder):
    import ezdxf
    import trimesh

    solids, drawings = {}, {}
    for file in sorted(folder.glob("*.stl")):
        loaded = trimesh.load(file)
        meshes = loaded.geometry.values() if hasattr(loaded, "geometry") else [loaded]
        solids[file.name] = [
            {"closed": bool(mesh.is_watertight and mesh.is_winding_consistent), "volume": float(mesh.volume)} for mesh in meshes
        ]
    for file in sorted(folder.glob("*.dxf")):
        drawing = ezdxf.readfile(file)
        found = drawing.audit()
        layers = collections.Counter(entity.dxf.layer for entity in drawing.modelspace())
        drawings[file.name] = {"errors": len(found.errors) + len(found.fixes), "layers": layers}
    return {"solids": solids, "drawings": drawings}


if __name__ == "__main__":
    question, folder = sys.argv[1:]
    questions = {"loops": loops, "plates": plates, "loads": loads, "drive": drive, "drake": drake, "shop": shop}
    answer = questions[question](pathlib.Path(folder))
    print(json.dumps(answer))
