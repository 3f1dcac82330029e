package aprsim;

import java.io.BufferedReader;
import java.io.InputStreamReader;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.concurrent.Future;
import java.util.function.Supplier;

/** Reads one command a line from standard input. Answers are lines "@ ..." on standard output, between the controller's own. */
public final class Console {
  public interface Handler {
    /** Executes one command and returns its answer, or null for none. */
    String run(String command, String[] arguments) throws Exception;
  }

  /** Writes an answer at the beginning of a line: the controller may have written half a line. */
  public static synchronized void say(String text) {
    System.out.print("\n@ " + text.replace('\n', ' ') + "\n");
    System.out.flush();
  }

  /** Runs until "quit" or the end of the input, and then ends the process. */
  public static void serve(Handler handler) throws Exception {
    BufferedReader in = new BufferedReader(new InputStreamReader(System.in, StandardCharsets.UTF_8));
    say("ready");
    for (String line; (line = in.readLine()) != null && !line.equals("quit"); ) {
      String[] words = line.trim().split(" +");
      try {
        String answer = handler.run(words[0], Arrays.copyOfRange(words, 1, words.length));
        if (answer != null) say(words[0] + " " + answer);
      } catch (Throwable fault) {
        fault.printStackTrace();
        say(words[0] + " failed: " + reason(fault));
      }
    }
    Runtime.getRuntime().halt(0);
  }

  /** Answers "NAME ended true" or "NAME ended false" once there is a result, followed by the remark. */
  public static void follow(String name, Future<Boolean> result, Supplier<String> remark) {
    new Thread(
            () -> {
              String end;
              try {
                end = String.valueOf(result.get());
              } catch (Throwable fault) {
                fault.printStackTrace();
                end = "false " + reason(fault);
              }
              say(name + " ended " + end + " " + remark.get());
            })
        .start();
  }

  /** The innermost cause, in one line. */
  public static String reason(Throwable fault) {
    while (fault.getCause() != null) fault = fault.getCause();
    String text = String.valueOf(fault.getMessage());
    return fault.getClass().getSimpleName() + ": " + text.substring(0, Math.min(300, text.length()));
  }
}
