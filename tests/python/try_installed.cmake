# Installs library and package into a prefix of its own, and imports the package from there.
file(REMOVE_RECURSE ${prefix})
foreach(component runtime python)
  execute_process(COMMAND ${CMAKE_COMMAND} --install ${build_dir} --prefix ${prefix} --component ${component}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
file(WRITE ${prefix}/try.py "
import tanor
assert tanor.__file__.startswith('${prefix}/'), tanor.__file__
libraries = [line.split()[-1] for line in open('/proc/self/maps') if 'libtanor.so' in line]
assert libraries and all(name.startswith('${prefix}/') for name in libraries), libraries
")
execute_process(COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/${folder} ${python} ${prefix}/try.py
  COMMAND_ERROR_IS_FATAL ANY)
