"""Reads a run with ParaView. To be run by pvpython, under xvfb-run where there is no display:

    xvfb-run -a pvpython check_paraview.py FOLDER

The three XDMF readers must show each frame with the points and cells that run.vtkhdf says (by h5py-free counting: the
sizes stand in run.xmf); ParaView 5.13 and later must read run.vtkhdf too. Exits 0, or 1 with the first difference.
"""
import os
import sys
import xml.etree.ElementTree as tree

from paraview import servermanager
from paraview.simple import GetParaViewVersion, XDMFReader, Xdmf3ReaderS, Xdmf3ReaderT


def expected(path):
    """[(time, points, cells)] of all bodies together, from the text of run.xmf."""
    rows = []
    for step in tree.parse(path).getroot().findall("./Domain/Grid/Grid"):
        points = sum(int(i.attrib["Dimensions"].split()[0]) for i in step.findall("Grid/Geometry/DataItem"))
        cells = sum(int(t.attrib["NumberOfElements"]) for t in step.findall("Grid/Topology"))
        rows.append((float(step.find("Time").attrib["Value"]), points, cells))
    return rows


def leaves(data):
    if not data.IsA("vtkCompositeDataSet"):
        return [data]
    found, it = [], data.NewIterator()
    it.InitTraversal()
    while not it.IsDoneWithTraversal():
        found.append(it.GetCurrentDataObject())
        it.GoToNextItem()
    return found


def read(reader, name, rows, count_cells):
    times = list(reader.TimestepValues) if hasattr(reader.TimestepValues, "__len__") else [reader.TimestepValues]
    if len(times) != len(rows):
        return f"{name} sees {len(times)} frames, not {len(rows)}"
    for time, points, cells in rows:
        reader.UpdatePipeline(time)
        got = leaves(servermanager.Fetch(reader))
        seen = (sum(x.GetNumberOfPoints() for x in got), sum(x.GetNumberOfCells() for x in got))
        if seen[0] != points or (count_cells and seen[1] != cells):
            return f"{name} at {time} sees {seen} points and cells, not {(points, cells)}"
    print(f"{name}: {len(rows)} frames, last one {rows[-1][1:]} points and cells")
    return ""


def main(folder):
    version = GetParaViewVersion()
    print("ParaView", version)
    path = os.path.join(os.path.abspath(folder), "run.xmf")
    rows = expected(path)
    problems = [read(kind(**{key: [path]}), kind.__name__, rows, True)
                for kind, key in ((XDMFReader, "FileNames"), (Xdmf3ReaderS, "FileName"), (Xdmf3ReaderT, "FileName"))]
    if (version.major, version.minor) >= (5, 13):
        from paraview.simple import VTKHDFReader

        reader = VTKHDFReader(FileName=[os.path.join(os.path.abspath(folder), "run.vtkhdf")])
        # A poly-vertex is one cell here, and as many as points in XDMF.
        problems.append(read(reader, "VTKHDFReader", rows, False))
    for problem in filter(None, problems):
        print("broken:", problem)
    return 1 if any(problems) else 0


sys.exit(main(sys.argv[1]))
