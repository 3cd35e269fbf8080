#!/usr/bin/python3
"""Checks a run's run.vtkhdf and run.xmf against the layout that they promise, rule by rule.

    check_run.py FOLDER [FRAMES]

FRAMES: how many frames there must be. Prints what it checked and exits 0, or the first broken rule and exits 1.
"""
import os
import re
import sys
import xml.etree.ElementTree as tree

import h5py
import numpy as np

CELLS = ("Vertices", "Lines", "Polygons", "Strips")


class Broken(Exception):
    pass


def need(condition, message):
    if not condition:
        raise Broken(message)


def fixed_ascii(owner, name):
    kind = owner.attrs.get_id(name).get_type()
    need(kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str(), f"{owner.name}@{name} is no fixed-length text")
    need(kind.get_cset() == h5py.h5t.CSET_ASCII, f"{owner.name}@{name} is not ASCII")
    text = bytes(owner.attrs[name])
    need(kind.get_size() == len(text), f"{owner.name}@{name} is padded")
    return text.decode("ascii")


def table(group, name, kind, columns=None):
    """A dataset of the promised type and shape, read whole."""
    need(name in group, f"{group.name}/{name} is missing")
    data = group[name]
    need(data.dtype == np.dtype(kind), f"{data.name} is {data.dtype}, not {kind}")
    need(data.ndim == (1 if columns is None else 2), f"{data.name} has rank {data.ndim}")
    need(columns is None or data.shape[1] == columns, f"{data.name} has {data.shape[1:]} columns, not {columns}")
    return data[()]


def head(group, version):
    got = group.attrs["Version"]
    need(got.dtype == np.int64 and list(got) == version, f"{group.name}@Version is {got} ({got.dtype}), not {version}")
    return fixed_ascii(group, "Type")


def ordered(group):
    flags = group.id.get_create_plist().get_link_creation_order()
    need(flags & h5py.h5p.CRT_ORDER_TRACKED and flags & h5py.h5p.CRT_ORDER_INDEXED, f"{group.name}: creation order is not kept")


def check_block(block, name, version, fps):
    need(head(block, version) == "PolyData", f"{block.name} is no PolyData")
    ordered(block)
    steps = block["Steps"]
    count = steps.attrs["NSteps"]
    need(np.dtype(type(count)) == np.int64, f"{steps.name}@NSteps is no 64-bit integer")
    count = int(count)
    values = table(steps, "Values", "f8")
    need(len(values) == count, f"{steps.name}/Values has {len(values)} rows, NSteps is {count}")
    frames = np.rint(values * fps)
    need(np.array_equal(values, frames / fps), f"{steps.name}/Values are not exactly frame / fps")
    need(np.all(np.diff(values) > 0), f"{steps.name}/Values do not ascend")

    points = block["Points"]
    need(points.dtype == np.float32 and points.ndim == 2 and points.shape[1] == 3, f"{points.name} is not f4[n,3]")
    need(points.chunks is not None and points.maxshape == (None, 3), f"{points.name} is not chunked and unlimited")
    sizes = table(block, "NumberOfPoints", "i8")
    offsets = {n: table(steps, n, "i8") for n in ("PartOffsets", "NumberOfParts", "PointOffsets")}
    cell_offsets = table(steps, "CellOffsets", "i8", 4)
    id_offsets = table(steps, "ConnectivityIdOffsets", "i8", 4)
    for n, v in {**offsets, "CellOffsets": cell_offsets, "ConnectivityIdOffsets": id_offsets}.items():
        need(len(v) == count, f"{steps.name}/{n} has {len(v)} rows, not {count}")
    need(np.all(offsets["NumberOfParts"] == 1), f"{steps.name}/NumberOfParts is not 1 throughout")
    cells = {c: {n: table(block[c], n, "i8") for n in ("NumberOfCells", "NumberOfConnectivityIds", "Connectivity", "Offsets")} for c in CELLS}
    surface = cells["Polygons"]["NumberOfCells"].any()
    parts = len(sizes) if surface else count  # of a surface: another whenever triangles have torn
    need(not surface or 1 <= parts <= count + 1, f"{block.name} has {parts} topologies in {count} steps")
    need(len(sizes) == parts, f"{block.name}/NumberOfPoints has {len(sizes)} parts, not {parts}")
    for c in CELLS:
        got, where = cells[c], f"{block.name}/{c}"
        need(len(got["NumberOfCells"]) == parts and len(got["NumberOfConnectivityIds"]) == parts, f"{where} does not have {parts} parts")
        need(len(got["Offsets"]) == got["NumberOfCells"].sum() + parts, f"{where}/Offsets has {len(got['Offsets'])} entries")
        if c != ("Polygons" if surface else "Vertices"):
            need(not got["NumberOfCells"].any() and not len(got["Connectivity"]), f"{where} is not empty")
    if surface:
        part, got, triangles = offsets["PartOffsets"], cells["Polygons"], cells["Polygons"]["NumberOfCells"]
        need(np.all(np.isin(np.diff(part), (0, 1))) and part.min(initial=0) >= 0 and part.max(initial=0) < parts, f"{steps.name}/PartOffsets do not go through the topologies")
        before = np.concatenate([[0], np.cumsum(triangles)])[:-1]
        need(np.array_equal(cell_offsets[:, 2], before[part]) and not cell_offsets[:, (0, 1, 3)].any(), f"{steps.name}/CellOffsets are wrong")
        need(np.array_equal(id_offsets[:, 2], 3 * before[part]) and not id_offsets[:, (0, 1, 3)].any(), f"{steps.name}/ConnectivityIdOffsets are wrong")
        need(np.array_equal(got["NumberOfConnectivityIds"], 3 * triangles) and len(got["Connectivity"]) == 3 * triangles.sum(), f"{block.name}/Polygons is not made of triangles")
        need(np.array_equal(got["Offsets"], np.concatenate([3 * np.arange(n + 1) for n in triangles])), f"{block.name}/Polygons/Offsets are not 0, 3, 6, ...")
        need(got["Connectivity"].min(initial=0) >= 0 and got["Connectivity"].max(initial=0) < sizes[0], f"{block.name}/Polygons names points that are not there")
        need(np.all(sizes == sizes[0]), f"{block.name}/NumberOfPoints of a surface vary")
        corners = [got["Connectivity"][3 * before[p]:3 * (before[p] + triangles[p])] for p in part]
        sizes = np.repeat(sizes[:1], count)
    else:
        got = cells["Vertices"]
        need(not id_offsets.any(), f"{steps.name}/ConnectivityIdOffsets are not 0 throughout")
        need(np.array_equal(offsets["PartOffsets"], np.arange(count)), f"{steps.name}/PartOffsets are not 0, 1, 2, ...")
        need(np.array_equal(got["NumberOfCells"], (sizes > 0).astype("i8")), f"{block.name}/Vertices: not one cell a step, none where it is empty")
        need(np.array_equal(got["NumberOfConnectivityIds"], sizes), f"{block.name}/Vertices: not every point is in the cell")
        need(np.array_equal(got["Connectivity"], np.arange(sizes.max(initial=0))), f"{block.name}/Vertices/Connectivity is not 0, 1, ... of the largest step")
        wanted = [x for n in sizes for x in ([0, n] if n else [0])]
        need(list(got["Offsets"]) == wanted, f"{block.name}/Vertices/Offsets are wrong")
        before = np.concatenate([[0], np.cumsum(got["NumberOfCells"])])[:count]
        need(np.array_equal(cell_offsets[:, 0], before) and not cell_offsets[:, 1:].any(), f"{steps.name}/CellOffsets are wrong")
    starts = np.concatenate([[0], np.cumsum(sizes)])[:count].astype("i8")
    need(np.array_equal(offsets["PointOffsets"], starts), f"{steps.name}/PointOffsets are not the sums of the sizes before")
    need(len(points) == sizes.sum(), f"{points.name} has {len(points)} rows, the steps {sizes.sum()}")
    need(np.isfinite(points[()]).all(), f"{points.name} has values that are not finite")

    arrays = {"position": points}
    need(list(block["PointData"]) == list(steps["PointDataOffsets"]), f"{block.name}: PointData and PointDataOffsets name different arrays")
    for array, data in block["PointData"].items():
        need("/" not in array and "." not in array, f"{data.name}: a name with / or .")
        need(data.dtype == np.float32 and data.maxshape[0] is None and len(data) == len(points), f"{data.name} is not f4 with a row a point")
        need(np.isfinite(data[()]).all(), f"{data.name} has values that are not finite")
        need(np.array_equal(table(steps["PointDataOffsets"], array, "i8"), starts), f"{steps.name}/PointDataOffsets/{array} are wrong")
        arrays[array] = data
    return {"name": name, "values": values, "frames": frames.astype(int), "sizes": sizes, "starts": starts, "arrays": arrays, "surface": surface,
            "corners": corners if surface else None, "path": block.name}


def check_views(file, blocks):
    steps = blocks[0]["frames"]
    need(len(file["frames"]) == len(steps) if len(steps) else "frames" not in file, "/frames does not hold one group a step")
    for k, frame in enumerate(steps):
        for b in blocks:
            folder, n, start = f"/frames/{frame:06d}/{b['name']}", b["sizes"][k], b["starts"][k]
            if n == 0:
                need(folder not in file, f"{folder} exists for an empty step")
                continue
            names = set(b["arrays"]) | (set() if b["surface"] else {"id"})
            if b["surface"] and "corners" in file[folder]:  # a surface that tears
                view = file[f"{folder}/corners"]
                need(view.is_virtual and np.array_equal(view[()], b["corners"][k]), f"{view.name} is not what is left of the triangles")
                names.add("corners")
            need(set(file[folder]) == names, f"{folder} holds {sorted(file[folder])}, not {sorted(names)}")
            for array, data in b["arrays"].items():
                view = file[f"{folder}/{array}"]
                need(view.is_virtual and view.virtual_sources()[0].file_name == ".", f"{view.name} is no virtual dataset of this file")
                need(np.array_equal(view[()], data[start:start + n]), f"{view.name} is not the slice of {data.name}")
            if not b["surface"]:
                view = file[f"{folder}/id"]
                need(view.is_virtual and view.dtype == np.int32 and np.array_equal(view[()], np.arange(n)), f"{view.name} is not 0, 1, ...")


def check_xdmf(folder, file, blocks):
    root = tree.parse(os.path.join(folder, "run.xmf")).getroot()
    need(root.tag == "Xdmf" and root.attrib["Version"].startswith("3"), "run.xmf is no XDMF 3")
    steps = root.findall("./Domain/Grid[@CollectionType='Temporal']/Grid[@CollectionType='Spatial']")
    need(len(steps) == len(blocks[0]["frames"]), f"run.xmf has {len(steps)} steps, run.vtkhdf {len(blocks[0]['frames'])}")
    kinds, seen = {"Float": "f", "Int": "i"}, 0
    for k, step in enumerate(steps):
        time = float(step.find("Time").attrib["Value"])
        need(time == blocks[0]["values"][k], f"step {k} of run.xmf is at {time}, not {blocks[0]['values'][k]}")
        present = [b for b in blocks if b["sizes"][k] > 0 and (not b["surface"] or len(b["corners"][k]))]
        grids = step.findall("Grid")
        need([g.attrib["Name"] for g in grids] == [b["name"] for b in present], f"step {k} of run.xmf names other bodies")
        for grid, b in zip(grids, present):
            kind = grid.find("Topology").attrib
            if b["surface"]:
                need(kind["TopologyType"] == "Triangle" and 3 * int(kind["NumberOfElements"]) == len(b["corners"][k]), f"step {k}, {b['name']}: topology")
            else:
                need(kind["TopologyType"] == "Polyvertex" and int(kind["NumberOfElements"]) == b["sizes"][k], f"step {k}, {b['name']}: topology")
            need(grid.find("Topology/DataItem") is not None, f"step {k}, {b['name']}: the ids are not explicit")
            need({a.attrib["Name"] for a in grid.findall("Attribute")} | {"position"} == set(b["arrays"]), f"step {k}, {b['name']}: attributes")
        for item in step.iter("DataItem"):
            name, path = item.text.split(":")
            need(name == "run.vtkhdf" and path in file, f"run.xmf refers to {item.text}, which is not there")
            data, shape = file[path], tuple(int(x) for x in item.attrib["Dimensions"].split())
            if path.endswith(("/Connectivity", "/corners", "/id")):
                need(data.ndim == 1 and len(data) == np.prod(shape), f"{path} has {data.shape}, run.xmf says {shape}")
            else:
                need(data.shape == shape, f"{path} has {data.shape}, run.xmf says {shape}")
            need(data.dtype.kind == kinds[item.attrib["NumberType"]] and data.dtype.itemsize == int(item.attrib["Precision"]), f"{path} is {data.dtype}")
            seen += 1
    return seen


def check(folder, wanted):
    with h5py.File(os.path.join(folder, "run.vtkhdf"), "r") as file:
        top, fps = file["VTKHDF"], float(file["sim"].attrs["fps"])
        need(fps > 0 and fixed_ascii(file["sim"], "engine"), "/sim does not say what wrote the file")
        ordered(top)
        kind = fixed_ascii(top, "Type")
        if kind == "PolyData":
            need(len(file["frames"] if "frames" in file else []) == 0 or len({n for f in file["frames"].values() for n in f}) == 1, "a single body has several views")
            names = [n for f in file.get("frames", {}).values() for n in f]
            blocks = [check_block(top, names[0] if names else "", [2, 0], fps)]
            need("Assembly" not in top, "a single body has an assembly")
        else:
            need(head(top, [2, 1]) == "PartitionedDataSetCollection", f"/VTKHDF is a {kind}")
            names = [n for n in top if n != "Assembly"]
            need(list(top["Assembly"]) and set(top["Assembly"]) == set(names), "the assembly does not name the bodies")
            ordered(top["Assembly"])
            blocks = []
            for name in names:
                need(re.fullmatch(r"[A-Za-z_][\w-]*", name), f"{name!r} is no name for a block")
                link = top["Assembly"][name].get(name, getlink=True)
                need(isinstance(link, h5py.SoftLink) and link.path == f"/VTKHDF/{name}", f"/VTKHDF/Assembly/{name}/{name} is no soft link to the block")
                index = top[name].attrs["Index"]
                need(np.dtype(type(index)) == np.int64, f"/VTKHDF/{name}@Index is no 64-bit integer")
                blocks.append((int(index), check_block(top[name], name, [2, 1], fps)))
            blocks = [b for _, b in sorted(blocks, key=lambda pair: pair[0])]
            need([int(top[b["name"]].attrs["Index"]) for b in blocks] == list(range(len(blocks))), "the indices of the blocks are not 0, 1, ...")
        for b in blocks[1:]:
            need(np.array_equal(b["values"], blocks[0]["values"]), f"{b['path']} has other steps than {blocks[0]['path']}")
        need(wanted is None or len(blocks[0]["values"]) == wanted, f"{len(blocks[0]['values'])} frames, not {wanted}")
        check_views(file, blocks)
        items = check_xdmf(folder, file, blocks)
        print(f"good: {len(blocks)} blocks, {len(blocks[0]['values'])} frames, {items} references of run.xmf")


if __name__ == "__main__":
    try:
        check(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else None)
    except (Broken, KeyError, OSError, tree.ParseError) as problem:
        print(f"broken: {problem}")
        sys.exit(1)
